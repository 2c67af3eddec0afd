#include "synthesis/sensors/olng_estimator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "datasets/virtual_sensors.h"
#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

constexpr double kNeighbourShare = 0.0075, kPathShare = 0.00025;

constexpr double kLeastNeighbours = 256, kMostNeighbours = 4096, kLeastPaths = 24, kMostPaths = 256;

}  // namespace

OlngModel::OlngModel(std::shared_ptr<const MotionBase> base, const OlngOptions& options) : base_(std::move(base)), options_(options) {
  if (base_->sensors().empty()) throw std::invalid_argument("OlngModel: the base has no sensors");
  if (options.neighbours < 0 || options.paths < 0 || !(options.sensor_exponent >= 0))
    throw std::invalid_argument("OlngModel: neighbours, paths and sensor_exponent must be 0 or more");
  const auto frames = base_->frame_count();
  const auto own = static_cast<double>(std::max<Eigen::Index>(1, base_->own_tempo_frames())), copies = static_cast<double>(frames) / own;
  if (options_.neighbours == 0) options_.neighbours = static_cast<int>(std::lround(std::min(kMostNeighbours, copies * std::max(kLeastNeighbours, kNeighbourShare * own))));
  if (options_.paths == 0) options_.paths = static_cast<int>(std::lround(std::clamp(kPathShare * own, kLeastPaths, kMostPaths)));
  options_.neighbours = static_cast<int>(std::min<Eigen::Index>(options_.neighbours, frames));
  options_.paths = std::min(options_.paths, options_.neighbours);

  const Eigen::MatrixXf& readings = base_->accelerations();
  scale_.resize(readings.rows());
  for (Eigen::Index s = 0; s < readings.rows(); s += 3) {
    const Eigen::MatrixXd sensor = readings.middleRows(s, 3).cast<double>();
    const double deviation = std::sqrt((sensor.colwise() - sensor.rowwise().mean()).squaredNorm() / static_cast<double>(sensor.size()));
    // A sensor that reads one value throughout has no scale of its own.
    scale_.segment(s, 3).setConstant(static_cast<float>(std::pow(std::max(deviation, 1e-3), -options.sensor_exponent)));
  }
  search_ = std::make_unique<NeighbourSearch>(scale_.asDiagonal() * readings);

  const std::vector<int> joints = JointsOf(base_->sensors(), base_->skeleton());
  const std::vector<int>& measured = base_->measured_joints();
  for (std::size_t s = 0; s < joints.size(); ++s) {
    const auto place = std::find(measured.begin(), measured.end(), joints[s]);
    if (place == measured.end()) continue;  // on the pelvis, say, which does not move in its own frame
    const int joint = static_cast<int>(place - measured.begin());
    if (std::find(controlled_.begin(), controlled_.end(), joint) != controlled_.end()) continue;
    controlled_.push_back(joint);
    controlling_.push_back(static_cast<int>(s));
  }
}

std::vector<char> OlngModel::Follows(bool backwards) const {
  const Eigen::Index frames = base_->frame_count();
  std::vector<char> follows(static_cast<std::size_t>(frames), 0);
  for (Eigen::Index f = 0; f < frames; ++f) {
    if (base_->follows(f)) follows[static_cast<std::size_t>(backwards ? frames - f : f)] = 1;
  }
  return follows;
}

const std::vector<Neighbour>& NeighbourStream::Next(const Eigen::VectorXd& reading) {
  const Eigen::VectorXf query = model_->scale().cwiseProduct(reading.cast<float>());
  // The K frames that were nearest to the last reading are no farther from this one than then and the way between the readings together.
  float bound = std::numeric_limits<float>::infinity();
  if (query_.size() != 0) {
    const float radius = (farthest_ + (query - query_).norm()) * 1.0001F + 1e-6F;
    bound = radius * radius;
  }
  model_->search().Nearest(query, model_->options().neighbours, &nearest_, bound);
  query_ = query;
  farthest_ = std::sqrt(std::max_element(nearest_.begin(), nearest_.end())->squared_distance);
  return nearest_;
}

OlngEstimator::OlngEstimator(std::shared_ptr<const OlngModel> model)
    : model_(std::move(model)), graph_(model_->Follows(false), model_->options().graph), neighbours_(model_) {}

void OlngEstimator::KeepBest(std::vector<NeighbourPath> paths) {
  const OlngOptions& options = model_->options();
  best_ = std::move(paths);
  const auto cheaper = [](const NeighbourPath& a, const NeighbourPath& b) { return a.cost != b.cost ? a.cost < b.cost : a.frame < b.frame; };
  const std::size_t count = std::min(best_.size(), static_cast<std::size_t>(options.paths));
  const std::size_t sorted = std::min(best_.size(), count + 1);
  std::partial_sort(best_.begin(), best_.begin() + static_cast<std::ptrdiff_t>(sorted), best_.end(), cheaper);
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

NeighbourhoodTargets OlngEstimator::Targets() const {
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
    if (!base.follows(frame)) ++frame;
    if (!base.follows(frame - 1)) ++frame;
    const double tempo = path.tempo;
    const Eigen::VectorXd newest = tracks.col(frame).cast<double>(), middle = tracks.col(frame - 1).cast<double>(), oldest = tracks.col(frame - 2).cast<double>();
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

void OlngEstimator::Check(const Eigen::VectorXd& reading) const {
  const Eigen::Index wanted = model_->base().accelerations().rows();
  if (reading.size() != wanted) throw std::invalid_argument("OlngEstimator: expected " + std::to_string(wanted) + " values, got " + std::to_string(reading.size()));
  if (!reading.allFinite()) throw std::invalid_argument("OlngEstimator: a reading is not finite");
}

BasePose OlngEstimator::Next(const Eigen::VectorXd& reading) {
  Check(reading);
  if (model_->options().pose == OlngPose::kNearest) {
    std::vector<Neighbour> nearest;
    model_->search().Nearest(model_->scale().cwiseProduct(reading.cast<float>()), 1, &nearest);
    return model_->base().Pose(nearest.front().index);
  }
  return Next(reading, graph_.Update(neighbours_.Next(reading)));
}

BasePose OlngEstimator::Next(const Eigen::VectorXd& reading, std::vector<NeighbourPath> paths) {
  Check(reading);
  if (model_->options().pose == OlngPose::kNearest) throw std::invalid_argument("OlngEstimator: the nearest frame alone needs no paths");
  const auto outside = [&](const NeighbourPath& path) { return path.frame < 0 || path.frame >= model_->base().frame_count(); };
  if (paths.empty() || std::any_of(paths.begin(), paths.end(), outside)) throw std::invalid_argument("OlngEstimator: no paths, or one that is not of the base");
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
