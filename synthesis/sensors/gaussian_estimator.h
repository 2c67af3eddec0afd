#pragma once

#include <memory>
#include <vector>

#include "synthesis/sensors/pose_channels.h"
#include "synthesis/sensors/pose_clusters.h"
#include "synthesis/sensors/pose_estimator.h"
#include "synthesis/sensors/pose_reduction.h"
#include "synthesis/sensors/radial_basis_map.h"

namespace morphograph {

struct GaussianOptions {
  PoseReductionOptions reduction;
  PoseClusterOptions clusters;
  RadialBasisOptions map{.centres = 60, .ridge = 2e-3, .ridge_samples = 20};  // from poses to readings
  ClusterChoice choice = ClusterChoice::kFiltered;
  double evidence = 0.3;
  double smoothness_weight = 0.2, control_weight = 0.8;  // Xie's omega_s, omega_c
  /// Unit of the smoothness term, in root mean squares of what it measures in the base. Below 1 readings jolt poses less than a captured motion's own
  /// changes would allow: control residuals of neighbouring frames err alike, which the sum of terms does not know.
  double smoothness_unit = 0.65;
  double damping = 0.8;       // of the motion that is carried on (Eq. 6.3 has 1)
  int control_readings = 4;   // the present one and those before it that the control term compares (Eq. 6.4 has 1) …
  int control_stride = 2;     // … so many frames apart
  int max_iterations = 4;     // of Levenberg-Marquardt
  /// Time over which it is watched how much more readings err than those of the base do (in variances); so much less they then count. 0: not at all.
  double surprise_s = 1;
  double surprise_control_power = 0.6;   // to which that is taken in the control term …
  double surprise_evidence_power = 1.5;  // … and in what tells clusters
  /// Power of how much more readings change from frame to frame, over the same time, than those of the base do: so much larger is the unit of the
  /// smoothness term. 0: it is the same for slow motion and quick.
  double activity_power = 0.75;
  int jobs = 1;
};

/// What the method learns of a base (Xie 5.3.2). Immutable; streams share it.
struct GaussianModel {
  /// @throws std::invalid_argument for options out of range (LLE has no coordinates that could be optimised), or a base without sensors.
  GaussianModel(const MotionBase& base, const GaussianOptions& options);

  GaussianOptions options;
  double frame_rate_hz = 0;
  PoseChannels channels;
  PoseReduction reduction;
  PoseClusters clusters;
  std::vector<Eigen::VectorXd> means;        // of each cluster's coordinates
  std::vector<Eigen::MatrixXd> covariances;
  std::vector<RadialBasisMap> readings;      // G_j: from coordinates to what sensors read now and before, latest first
  std::vector<Eigen::MatrixXd> reading_errors;  // covariance of what it leaves
  Eigen::VectorXd changes;                   // (components): unit of the smoothness term
  double reading_change_m_s2 = 0;            // root mean square of readings' change from one frame to the next
};

/// Poses from readings by optimisation (Xie 6.2): the pose q of least
///
///   (q - m)^T C^-1 (q - m) + 0.2 |q - q' - d (q' - q'')|^2 + 0.8 |G(q) - c|^2        (Eq. 6.2, 6.3, 6.4)
///
/// with q', q'' the poses before, c the reading, by Levenberg-Marquardt with exact derivatives.
///
/// Differs from Xie: the minimum is over q (6.1 prints c). The last two terms are in standard deviations of the base, so that 0.2 and 0.8 do not hang on units.
/// c has the readings of the last frames too, as far as the window of the interpolating method reaches: one reading says little of a pose.
/// m, C and G are of all clusters that the readings so far allow, weighed by their probability ("neighbouring clusters", 6.2), so that
/// they change gradually. A body unlike those of the base reads otherwise than G says by far more than sensors there do, and every reading would jolt the pose: how much more is watched
/// (a running mean), and the third term and what tells clusters count less by a power of it. A noise of that size would have 1 for both; but errors go on from frame to frame, which
/// hurts clusters more (they switch) and the pose less.
/// The second term's unit follows how quick the motion is: readings that change half as much as those of the base come
/// from a motion whose own changes are that much smaller.
/// The motion carried on is damped. Coordinates are common to all clusters, so q may leave any one of them.
class GaussianEstimator : public PoseEstimator {
 public:
  explicit GaussianEstimator(std::shared_ptr<const GaussianModel> model);
  BasePose Next(const Eigen::VectorXd& reading) override;

 private:
  std::shared_ptr<const GaussianModel> model_;
  ClusterFilter filter_;
  Eigen::MatrixXf recent_;  // (values x frames): readings, cyclic
  Eigen::Index count_ = 0;
  Eigen::VectorXd last_, before_;  // coordinates; empty at the start
  double surprise_ = 1;
  double activity_ = 1;  // mean square of readings' changes of late, in those of the base
};

/// The terms above as residuals of coordinates, for a solver. Public for tests.
class GaussianPoseCost {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };

  /// @param shares  probability of each cluster, (clusters). @param expected  where the motion before leads; empty at the start.
  /// @param readings  as GaussianModel::readings say them: the latest first.
  /// @param surprise  variance of readings' errors, times that in the base, 1 or more.
  /// @param activity  what the unit of the smoothness term is multiplied with, positive.
  GaussianPoseCost(const GaussianModel& model, const Eigen::VectorXf& shares, const Eigen::VectorXf& readings, const Eigen::VectorXd& expected,
                   double surprise = 1, double activity = 1);
  int NumResiduals() const;
  int NumParameters() const { return static_cast<int>(mean_.size()); }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// Mean square of the readings' errors at these coordinates, in variances of the base: about 1 where a body reads as those of the base.
  double Surprise(const Eigen::VectorXd& coordinates) const;
  /// @param jacobian  (residuals x parameters), column by column, or null.
  bool operator()(const double* coordinates, double* residuals, double* jacobian) const;

 private:
  const GaussianModel& model_;
  Eigen::VectorXf shares_, readings_;
  Eigen::VectorXd expected_, mean_;
  Eigen::MatrixXd whitening_;          // L^-1 of the poses' covariance L L^T
  Eigen::MatrixXd reading_whitening_;  // of the readings' errors
  double control_scale_ = 1;           // that it is multiplied with
  double activity_;
};

}  // namespace morphograph
