#include "synthesis/sensors/neighbourhood_energy.h"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "primitives/matrix_factors.h"
#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

Eigen::VectorXd GatherPositions(const MotionBase& base, const WorldPose& pose) {
  const std::vector<int>& joints = base.measured_joints();
  Eigen::VectorXd positions(3 * static_cast<Eigen::Index>(joints.size()));
  for (std::size_t n = 0; n < joints.size(); ++n) positions.segment<3>(3 * static_cast<Eigen::Index>(n)) = pose.positions.col(joints[n]);
  return positions;
}

// The derivative by positions, turned into that by rotations: forces on joints become moments about those above them.
Eigen::VectorXd MomentsOf(const MotionBase& base, const Eigen::VectorXd& rotations, const WorldPose& pose, const Eigen::VectorXd& by_positions) {
  const Skeleton& skeleton = base.skeleton();
  const Eigen::Index joints = skeleton.joint_count();
  // Forces and moments (about the origin) of all joints below each, without itself.
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, joints), moments = Eigen::Matrix3Xd::Zero(3, joints);
  Eigen::Matrix3Xd own = Eigen::Matrix3Xd::Zero(3, joints);
  for (std::size_t n = 0; n < base.measured_joints().size(); ++n)
    own.col(base.measured_joints()[n]) = by_positions.segment<3>(3 * static_cast<Eigen::Index>(n));
  for (Eigen::Index j = joints - 1; j > 0; --j) {
    const int parent = skeleton.parent(static_cast<int>(j));
    const Eigen::Vector3d force = own.col(j), place = pose.positions.col(j);
    forces.col(parent) += forces.col(j) + force;
    moments.col(parent) += moments.col(j) + place.cross(force);
  }
  Eigen::VectorXd by_rotations = Eigen::VectorXd::Zero(rotations.size());
  // The moving root (the first) turns the pelvis frame itself.
  for (std::size_t n = 1; n < base.active_joints().size(); ++n) {
    const int joint = base.active_joints()[n];
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(n);
    const Eigen::Vector3d place = pose.positions.col(joint), force = forces.col(joint), moment = moments.col(joint);
    const Eigen::Vector3d in_joint = pose.rotations[static_cast<std::size_t>(joint)].conjugate() * (moment - place.cross(force));
    by_rotations.segment<3>(at) = RightJacobian(rotations.segment<3>(at)).transpose() * in_joint;
  }
  return by_rotations;
}

Eigen::VectorXd Part(const Eigen::VectorXd& positions, const std::vector<int>& controlled) {
  Eigen::VectorXd part(3 * static_cast<Eigen::Index>(controlled.size()));
  for (std::size_t n = 0; n < controlled.size(); ++n) part.segment<3>(3 * static_cast<Eigen::Index>(n)) = positions.segment<3>(3 * controlled[n]);
  return part;
}

class EnergyFunction : public ceres::FirstOrderFunction {
 public:
  explicit EnergyFunction(const NeighbourhoodEnergy& energy) : energy_(energy) {}
  int NumParameters() const override { return static_cast<int>(energy_.dims()); }
  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    Eigen::VectorXd derivative;
    *cost = energy_.Energy(Eigen::Map<const Eigen::VectorXd>(parameters, energy_.dims()), gradient ? &derivative : nullptr);
    if (gradient) Eigen::Map<Eigen::VectorXd>(gradient, energy_.dims()) = derivative;
    return true;
  }

 private:
  const NeighbourhoodEnergy& energy_;
};

}  // namespace

Eigen::VectorXd MeasuredPositions(const MotionBase& base, const Eigen::VectorXd& rotations) {
  WorldPose pose;
  base.PelvisPose(rotations, &pose);
  return GatherPositions(base, pose);
}

Eigen::VectorXd PullBack(const MotionBase& base, const Eigen::VectorXd& rotations, const Eigen::VectorXd& by_positions) {
  WorldPose pose;
  base.PelvisPose(rotations, &pose);
  return MomentsOf(base, rotations, pose, by_positions);
}

NeighbourhoodEnergy::NeighbourhoodEnergy(const MotionBase& base, NeighbourhoodTargets targets, const NeighbourhoodEnergyOptions& options)
    : base_(base), options_(options), controlled_(std::move(targets.controlled)), inertial_(std::move(targets.inertial)) {
  const Eigen::VectorXd& weights = targets.weights;
  const Eigen::Index positions = 3 * static_cast<Eigen::Index>(base.measured_joints().size());
  const auto fits = [&](const Eigen::MatrixXd& matrix, Eigen::Index rows) {
    return matrix.size() == 0 || (matrix.rows() == rows && matrix.cols() == weights.size());
  };
  if (targets.poses.size() == 0 || !fits(targets.poses, base.rotations().rows()) || !fits(targets.motion, positions) ||
      !fits(targets.smooth, positions) || !fits(targets.control, 3 * static_cast<Eigen::Index>(controlled_.size())) ||
      (inertial_.size() != 0 && inertial_.size() != positions))
    throw std::invalid_argument("NeighbourhoodEnergy: targets whose sizes do not fit together");
  options_.motion *= targets.trust;
  options_.smooth *= targets.trust;
  options_.control *= targets.trust;
  FindSubspace(targets.poses, weights);

  // In the subspace a pose is short; what of a neighbour lies outside is a constant that softens its kernel.
  const Eigen::MatrixXd about = targets.poses.colwise() - mean_;
  const Eigen::MatrixXd coordinates = basis_.transpose() * about;
  const bool kernels = options_.kind == PriorKind::kKernel;
  if (kernels) {
    const double softening_rad = options_.softening_rad * options_.softening_rad;
    const Eigen::VectorXd outside = (about.colwise().squaredNorm() - coordinates.colwise().squaredNorm()).transpose().cwiseMax(0.0);
    pose_.emplace(coordinates, weights, outside.array() + softening_rad);
  } else {
    gaussian_pose_.emplace(coordinates, weights, options_.ridge_rad, options_.squared);
  }
  const auto add = [&](Eigen::MatrixXd&& samples, std::optional<KernelPrior>* kernel, std::optional<GaussianPrior>* gaussian) {
    if (samples.size() == 0) return;
    if (kernels) {
      kernel->emplace(std::move(samples), weights, Eigen::VectorXd::Constant(weights.size(), options_.softening_m * options_.softening_m));
    } else {
      gaussian->emplace(samples, weights, options_.ridge_m, options_.squared);
    }
  };
  add(std::move(targets.control), &control_, &gaussian_control_);
  if (options_.kind == PriorKind::kGaussianLeastAcceleration) return;
  inertial_.resize(0);
  add(std::move(targets.motion), &motion_, &gaussian_motion_);
  add(std::move(targets.smooth), &smooth_, &gaussian_smooth_);
}

void NeighbourhoodEnergy::FindSubspace(const Eigen::MatrixXd& poses, const Eigen::VectorXd& weights) {
  mean_ = poses * weights;
  const Eigen::MatrixXd scaled = (poses.colwise() - mean_) * weights.cwiseSqrt().asDiagonal();
  // Of the two products of the matrix with itself the smaller one.
  const bool by_neighbours = scaled.cols() < scaled.rows();
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(by_neighbours ? scaled.cols() : scaled.rows(), by_neighbours ? scaled.cols() : scaled.rows());
  if (by_neighbours) {
    product.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  } else {
    product.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
  }
  const SymmetricFactors factors = FactorSymmetric(product);
  const double whole = factors.values.cwiseMax(0.0).sum();
  // Directions in which a thousandth of a radian is not reached are rounding.
  const double least = std::max(1e-12 * whole, 1e-8);
  Eigen::Index kept = 0;
  double held = 0;
  for (Eigen::Index i = factors.values.size() - 1; i >= 0 && factors.values[i] > least && held < options_.kept_variance * whole; --i, ++kept)
    held += factors.values[i];
  basis_ = factors.vectors.rightCols(kept);
  if (by_neighbours) basis_ = scaled * basis_ * factors.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

double NeighbourhoodEnergy::Energy(const Eigen::VectorXd& coordinates, Eigen::VectorXd* gradient) const {
  double energy = 0;
  if (gradient) gradient->setZero(dims());
  const auto add = [&](const auto& prior, double weight, const Eigen::VectorXd& at, Eigen::VectorXd* derivative) {
    if (prior) energy += weight * prior->Energy(at, weight, derivative);
  };
  add(pose_, options_.prior * options_.pose, coordinates, gradient);
  add(gaussian_pose_, options_.prior * options_.pose, coordinates, gradient);
  if (!motion_ && !gaussian_motion_ && !control_ && !gaussian_control_) return energy;

  const Eigen::VectorXd rotations = Rotations(coordinates);
  WorldPose pose;
  base_.PelvisPose(rotations, &pose);
  const Eigen::VectorXd positions = GatherPositions(base_, pose);
  Eigen::VectorXd by_positions;
  if (gradient) by_positions.setZero(positions.size());
  Eigen::VectorXd* const by_positions_or_none = gradient ? &by_positions : nullptr;
  add(motion_, options_.prior * options_.motion, positions, by_positions_or_none);
  add(gaussian_motion_, options_.prior * options_.motion, positions, by_positions_or_none);
  add(smooth_, options_.prior * options_.smooth, positions, by_positions_or_none);
  add(gaussian_smooth_, options_.prior * options_.smooth, positions, by_positions_or_none);
  if (inertial_.size() != 0) {
    const double weight = options_.prior * options_.smooth / (options_.least_acceleration_m * options_.least_acceleration_m);
    const Eigen::VectorXd second_difference = positions - inertial_;
    energy += 0.5 * weight * second_difference.squaredNorm();
    if (gradient) by_positions += weight * second_difference;
  }
  if (control_ || gaussian_control_) {
    const Eigen::VectorXd part = Part(positions, controlled_);
    Eigen::VectorXd by_part;
    if (gradient) by_part.setZero(part.size());
    add(control_, options_.control, part, gradient ? &by_part : nullptr);
    add(gaussian_control_, options_.control, part, gradient ? &by_part : nullptr);
    for (std::size_t n = 0; gradient && n < controlled_.size(); ++n)
      by_positions.segment<3>(3 * controlled_[n]) += by_part.segment<3>(3 * static_cast<Eigen::Index>(n));
  }
  if (gradient) gradient->noalias() += basis_.transpose() * MomentsOf(base_, rotations, pose, by_positions);
  return energy;
}

Eigen::VectorXd NeighbourhoodEnergy::Minimise(const Eigen::VectorXd& start) const {
  Eigen::VectorXd coordinates = Coordinates(start);
  if (dims() == 0) return mean_;
  // The problem owns the function.
  const ceres::GradientProblem problem(new EnergyFunction(*this));
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::LBFGS;
  solver.max_num_iterations = options_.max_iterations;
  solver.function_tolerance = 1e-5;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  const Eigen::VectorXd first = coordinates;
  ceres::Solve(solver, problem, coordinates.data(), &summary);
  return Rotations(summary.IsSolutionUsable() && coordinates.allFinite() ? coordinates : first);
}

}  // namespace morphograph
