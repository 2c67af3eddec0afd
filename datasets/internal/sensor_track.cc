#include "datasets/internal/sensor_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/quantile.h"

namespace morphograph {
namespace {

// A spike stands alone: what lies on both sides of it differs less than this part of its height.
constexpr double kMostBetween[] = {0, 0.25, 1.0 / 6};
constexpr double kSameTime = 0.01;  // of a step

}  // namespace

SensorTrack::SensorTrack(const std::vector<double>& all_times_s, const Eigen::Ref<const Eigen::MatrixXd>& all_values) {
  std::vector<double> steps;
  for (std::size_t i = 0; i < all_times_s.size(); ++i) {
    const Eigen::Vector3d value = all_values.col(static_cast<Eigen::Index>(i));
    if (!value.allFinite()) continue;
    if (!times_s.empty()) steps.push_back(all_times_s[i] - times_s.back());
    times_s.push_back(all_times_s[i]);
    values.push_back(value);
  }
  if (!steps.empty()) step_s = Median(std::move(steps));
}

Eigen::Vector3d SensorTrack::Mean() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& value : values) sum += value;
  return values.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(values.size()));
}

double SensorTrack::MedianNorm() const {
  if (values.empty()) return 0;
  std::vector<double> norms;
  for (const Eigen::Vector3d& value : values) norms.push_back(value.norm());
  return Median(std::move(norms));
}

Eigen::Vector3d ValueAt(const SensorTrack& track, double time_s, const GapFilling& filling) {
  const std::vector<double>& times = track.times_s;
  const std::vector<Eigen::Vector3d>& values = track.values;
  const auto from_edge = [&](std::size_t edge, double distance_s) -> Eigen::Vector3d {
    if (!std::isfinite(filling.damping_s)) return values[edge];
    return filling.towards + (values[edge] - filling.towards) * std::exp(-std::max(0.0, distance_s) / filling.damping_s);
  };
  const double same_s = kSameTime * track.step_s;
  const std::size_t after = static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), time_s - same_s) - times.begin());
  if (after == times.size()) return from_edge(after - 1, time_s - times[after - 1] - track.step_s);
  if (times[after] <= time_s + same_s) return values[after];
  if (after == 0) return from_edge(0, times[0] - time_s - track.step_s);
  const std::size_t before = after - 1;
  const double gap_s = times[after] - times[before], s = (time_s - times[before]) / gap_s;
  const double longest_s = filling.longest_bridge_s + 1.5 * track.step_s;
  if (gap_s > longest_s) {
    return (1 - s) * from_edge(before, time_s - times[before]) + s * from_edge(after, times[after] - time_s);
  }
  const bool has_earlier = before > 0 && times[before] - times[before - 1] <= longest_s;
  const bool has_later = after + 1 < times.size() && times[after + 1] - times[after] <= longest_s;
  const std::size_t earlier = has_earlier ? before - 1 : before, later = has_later ? after + 1 : after;
  const Eigen::Vector3d start_slope = (values[after] - values[earlier]) / (times[after] - times[earlier]) * gap_s;
  const Eigen::Vector3d end_slope = (values[later] - values[before]) / (times[later] - times[before]) * gap_s;
  // Cubic Hermite on [0, 1].
  return (1 + 2 * s) * (1 - s) * (1 - s) * values[before] + s * (1 - s) * (1 - s) * start_slope + s * s * (3 - 2 * s) * values[after] +
         s * s * (s - 1) * end_slope;
}

SpikeMeasure MeasureSpike(const SensorTrack& track, std::size_t first, std::size_t width) {
  const Eigen::Vector3d &before = track.values[first - 1], &behind = track.values[first + width];
  SpikeMeasure measure;
  measure.between = (behind - before).norm();
  measure.height = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < width; ++i) {
    const double s = static_cast<double>(i + 1) / static_cast<double>(width + 1);
    measure.height = std::min(measure.height, (track.values[first + i] - (1 - s) * before - s * behind).norm());
  }
  return measure;
}

bool IsSpike(const SpikeMeasure& measure, std::size_t width, double threshold) {
  return measure.height > threshold && measure.between < kMostBetween[width] * measure.height;
}

}  // namespace morphograph
