#include "synthesis/sensors/olng_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "datasets/virtual_sensors.h"

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

std::vector<char> OlngModel::Follows(TimeDirection direction) const {
  const Eigen::Index frames = base_->frame_count();
  std::vector<char> follows(static_cast<std::size_t>(frames), 0);
  for (Eigen::Index f = 0; f < frames; ++f) {
    if (base_->follows(f)) follows[static_cast<std::size_t>(direction == TimeDirection::kBackwards ? frames - f : f)] = 1;
  }
  return follows;
}

void OlngModel::Check(const Eigen::VectorXd& reading) const {
  const Eigen::Index wanted = base_->accelerations().rows();
  if (reading.size() != wanted) throw std::invalid_argument("OlngModel: expected " + std::to_string(wanted) + " values a reading, got " + std::to_string(reading.size()));
  if (!reading.allFinite()) throw std::invalid_argument("OlngModel: a reading is not finite");
}

}  // namespace morphograph
