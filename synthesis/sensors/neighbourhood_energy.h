#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "synthesis/sensors/kernel_prior.h"
#include "synthesis/sensors/motion_base.h"

namespace morphograph {

enum class PriorKind {
  kKernel,                     // square-root kernels in every term (Tautges)
  kGaussian,                   // normal distributions in every term
  kGaussianLeastAcceleration,  // a normal distribution of the pose and of the control term, and least acceleration for smoothness (Chai & Hodgins 2005)
};

/// Weights of Tautges' Eqs. 2 and 3, as section 5.3 has them, and how the priors are made. Rotations count in rad, positions in metres.
struct NeighbourhoodEnergyOptions {
  PriorKind kind = PriorKind::kGaussian;  // nearer than kernels for people that the base does not hold, smoother for its unknown styles too, and no worse for what it knows (README, "Priors")
  double control = 1, prior = 5;
  double pose = 0.6, motion = 0.2, smooth = 0.2;  // within the prior
  double kept_variance = 0.99;                    // of the neighbours' poses by the subspace in which the pose is sought
  double softening_rad = 0.02, softening_m = 0.002;  // of kernels: below this distance they flatten out
  double ridge_rad = 0.02, ridge_m = 0.02;      // of normal distributions
  bool squared = true;                          // normal distributions: half the squared Mahalanobis distance, else the distance
  double least_acceleration_m = 0.1;            // kGaussianLeastAcceleration: a second difference that counts one half
  int max_iterations = 30;
};

/// What the neighbours say of the next pose, a column a neighbour. Matrices of terms that cannot be had yet (at the first frames) are empty.
struct NeighbourhoodTargets {
  Eigen::VectorXd weights;   // (neighbours), not negative, sum 1
  Eigen::MatrixXd poses;     // (rotations of the base x neighbours)
  Eigen::MatrixXd motion;    // (3 * measured joints x neighbours): Eq. 6, positions
  Eigen::MatrixXd smooth;    // the same of Eqs. 8 and 9: the position at which the neighbour's acceleration is met
  Eigen::MatrixXd control;   // (3 * controlled x neighbours): Eq. 10
  std::vector<int> controlled;  // joints next to sensors, as places in the base's measured joints
  Eigen::VectorXd inertial;  // (3 * measured joints): where the joints come by themselves, 2 x^t - x^{t-1}
  double trust = 1;          // 0 to 1: how much what goes on from the pose before counts: motion, smooth, control and least acceleration
};

/// The energy of a pose that neighbours of a reading define (Tautges Eq. 2), over the coordinates of the pose in the space that the neighbours' poses span: their weighted
/// principal components that hold most of their variance (section 5.3).
class NeighbourhoodEnergy {
 public:
  /// @throws std::invalid_argument for targets whose sizes do not fit together.
  NeighbourhoodEnergy(const MotionBase& base, NeighbourhoodTargets targets, const NeighbourhoodEnergyOptions& options);

  Eigen::Index dims() const { return basis_.cols(); }
  /// Rotations of the base at the coordinates, and the coordinates nearest to rotations.
  Eigen::VectorXd Rotations(const Eigen::VectorXd& coordinates) const { return mean_ + basis_ * coordinates; }
  Eigen::VectorXd Coordinates(const Eigen::VectorXd& rotations) const { return basis_.transpose() * (rotations - mean_); }

  /// @param gradient  (dims) if wanted.
  double Energy(const Eigen::VectorXd& coordinates, Eigen::VectorXd* gradient) const;

  /// The rotations of least energy that are found from `start` (L-BFGS). Those of `start` itself, put into the space, when nothing better is.
  Eigen::VectorXd Minimise(const Eigen::VectorXd& start) const;

 private:
  void FindSubspace(const Eigen::MatrixXd& poses, const Eigen::VectorXd& weights);

  const MotionBase& base_;
  NeighbourhoodEnergyOptions options_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd basis_;  // (rotations x dims), orthonormal
  std::optional<KernelPrior> pose_, motion_, smooth_, control_;
  std::optional<GaussianPrior> gaussian_pose_, gaussian_motion_, gaussian_smooth_, gaussian_control_;
  std::vector<int> controlled_;
  Eigen::VectorXd inertial_;
};

/// Positions of the base's measured joints in the pelvis frame (3 * measured joints) at the rotations.
Eigen::VectorXd MeasuredPositions(const MotionBase& base, const Eigen::VectorXd& rotations);

/// Turns the derivative of a function by MeasuredPositions() into that by the rotations.
Eigen::VectorXd PullBack(const MotionBase& base, const Eigen::VectorXd& rotations, const Eigen::VectorXd& by_positions);

}  // namespace morphograph
