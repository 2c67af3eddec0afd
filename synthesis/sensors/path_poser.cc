#include "synthesis/sensors/path_poser.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "datasets/virtual_sensors.h"
#include "primitives/rotation_math.h"

namespace morphograph {

PathPoser::PathPoser(std::shared_ptr<const OlngModel> model, TimeDirection direction)
    : model_(std::move(model)), step_(direction == TimeDirection::kForwards ? 1 : -1) {
  if (model_->options().pose == OlngPose::kNearest) throw std::invalid_argument("PathPoser: the nearest frame alone needs no paths");
}

bool PathPoser::Joined(Eigen::Index frame) const {
  const MotionBase& base = model_->base();
  return step_ > 0 ? base.follows(frame) : frame + 1 < base.frame_count() && base.follows(frame + 1);
}

void PathPoser::KeepBest(std::vector<NeighbourPath> paths) {
  const OlngOptions& options = model_->options();
  best_ = std::move(paths);
  const std::size_t count = std::min(best_.size(), static_cast<std::size_t>(options.paths));
  const std::size_t sorted = std::min(best_.size(), count + 1);
  std::partial_sort(best_.begin(), best_.begin() + static_cast<std::ptrdiff_t>(sorted), best_.end(), IsCheaper);
  const double dearest = best_[sorted - 1].cost;
  best_.resize(count);
  // Eq. 1.
  weights_.resize(static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) weights_[static_cast<Eigen::Index>(i)] = dearest - static_cast<double>(best_[i].cost);
  const double sum = weights_.sum();
  if (sum > 0) {
    weights_ /= sum;
  } else {
    weights_.setConstant(1 / static_cast<double>(count));
  }
}

NeighbourhoodTargets PathPoser::Targets() const {
  const MotionBase& base = model_->base();
  const auto count = static_cast<Eigen::Index>(best_.size());
  const Eigen::MatrixXf& tracks = base.positions();
  NeighbourhoodTargets targets;
  targets.weights = weights_;
  targets.trust = trust_;
  targets.poses.resize(base.rotations().rows(), count);
  for (Eigen::Index i = 0; i < count; ++i) targets.poses.col(i) = base.rotations().col(best_[static_cast<std::size_t>(i)].frame).cast<double>();
  if (positions_.size() == 0) return targets;

  const std::vector<int>& controlled = model_->controlled();
  const bool with_smooth = older_positions_.size() != 0;
  targets.motion.resize(tracks.rows(), count);
  if (with_smooth) {
    targets.smooth.resize(tracks.rows(), count);
    targets.inertial = 2 * positions_ - older_positions_;
  }
  Eigen::MatrixXd velocities(tracks.rows(), count);  // per frame, centred at the paths' previous frames
  for (Eigen::Index i = 0; i < count; ++i) {
    const NeighbourPath& path = best_[static_cast<std::size_t>(i)];
    // At the start of a clip the differences of its first frames.
    Eigen::Index frame = path.frame;
    if (!Joined(frame)) frame += step_;
    if (!Joined(frame - step_)) frame += step_;
    const double tempo = path.tempo;
    const Eigen::VectorXd newest = tracks.col(frame).cast<double>(), middle = tracks.col(frame - step_).cast<double>(),
                          oldest = tracks.col(frame - 2 * step_).cast<double>();
    targets.motion.col(i) = positions_ + tempo * (newest - middle);
    if (with_smooth) targets.smooth.col(i) = targets.inertial + tempo * tempo * (newest - 2 * middle + oldest);
    velocities.col(i) = 0.5 * tempo * (newest - oldest);
  }
  if (controlled.empty()) return targets;

  targets.controlled = controlled;
  targets.control.resize(3 * static_cast<Eigen::Index>(controlled.size()), count);
  WorldPose pose;
  base.PelvisPose(rotations_, &pose);
  const Eigen::Quaterniond tilt = base.LocalRotations(rotations_)[static_cast<std::size_t>(base.skeleton().moving_root())];
  const Eigen::Vector3d gravity = tilt.conjugate() * Eigen::Vector3d(0, kGravity_m_s2, 0);
  const double dt = 1 / base.frame_rate_hz();
  for (std::size_t n = 0; n < controlled.size(); ++n) {
    const Eigen::Index from = 3 * controlled[n], to = 3 * static_cast<Eigen::Index>(n);
    const Placement& sensor = base.sensors()[static_cast<std::size_t>(model_->controlling()[n])];
    const int joint = base.measured_joints()[static_cast<std::size_t>(controlled[n])];
    const Eigen::Vector3d measured = reading_.segment<3>(3 * model_->controlling()[n]);
    const Eigen::Vector3d acceleration = pose.rotations[static_cast<std::size_t>(joint)] * (sensor.joint_from_sensor * measured) - gravity;
    targets.control.middleRows<3>(to) =
        velocities.middleRows<3>(from).colwise() + (positions_.segment<3>(from) + 0.5 * dt * dt * acceleration);
  }
  return targets;
}

BasePose PathPoser::Next(const Eigen::VectorXd& reading, std::vector<NeighbourPath> paths) {
  model_->Check(reading);
  const auto outside = [&](const NeighbourPath& path) { return path.frame < 0 || path.frame >= model_->base().frame_count(); };
  if (paths.empty() || std::any_of(paths.begin(), paths.end(), outside)) throw std::invalid_argument("PathPoser: no paths, or one that is not of the base");
  KeepBest(std::move(paths));
  const MotionBase& base = model_->base();
  const OlngOptions& options = model_->options();
  BasePose pose;
  Eigen::Vector4d travel = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < best_.size(); ++i) {
    Eigen::Vector4d of_path = base.travel().col(best_[i].frame).cast<double>();
    of_path.head<3>() *= best_[i].tempo;
    travel += weights_[static_cast<Eigen::Index>(i)] * of_path;
  }
  pose.step = travel.head<3>();
  pose.height_m = travel[3];
  if (options.pose == OlngPose::kWeightedMean) {
    pose.rotations = Eigen::VectorXd::Zero(base.rotations().rows());
    for (std::size_t i = 0; i < best_.size(); ++i)
      pose.rotations += weights_[static_cast<Eigen::Index>(i)] * base.rotations().col(best_[i].frame).cast<double>();
    return pose;
  }
  const NeighbourhoodEnergy energy(base, Targets(), options.energy);
  // From the pose before (section 5.3); at first from the mean, which is the origin of the coordinates.
  pose.rotations = energy.Minimise(rotations_.size() == 0 ? energy.Rotations(Eigen::VectorXd::Zero(energy.dims())) : rotations_);
  older_positions_ = positions_;
  positions_ = MeasuredPositions(base, pose.rotations);
  rotations_ = pose.rotations;
  reading_ = reading;
  trust_ += (1 - trust_) / options.graph.window_frames;
  return pose;
}

}  // namespace morphograph
