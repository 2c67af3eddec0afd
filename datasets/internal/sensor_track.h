#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

/// What one sensor said, lost samples left out.
struct SensorTrack {
  std::vector<double> times_s;  // rising
  std::vector<Eigen::Vector3d> values;
  double step_s = 0;            // median step; 0 with fewer than two samples

  /// @param values  (3 x times); a column that is not all finite is left out.
  SensorTrack(const std::vector<double>& all_times_s, const Eigen::Ref<const Eigen::MatrixXd>& all_values);
  SensorTrack() = default;

  bool empty() const { return values.empty(); }
  Eigen::Vector3d Mean() const;
  /// Medians over samples: of the length, and 0 for none.
  double MedianNorm() const;
};

/// How a track is continued where it is silent.
struct GapFilling {
  /// Gaps that lack no more than this are bridged by a cubic through the four samples around (Catmull-Rom, slopes over unequal steps).
  double longest_bridge_s = 0.08;
  /// In longer ones the value goes from both edges to `towards`, by exp(-t / this); infinite: straight from edge to edge.
  double damping_s = 0.1;
  Eigen::Vector3d towards = Eigen::Vector3d::Zero();
};

/// The track at any time. Within 1 % of a step of a sample it is that sample. @param track  not empty.
Eigen::Vector3d ValueAt(const SensorTrack& track, double time_s, const GapFilling& filling);

/// How far sample i (of a block of `width`) stands out from the straight line between the samples before and behind the block, and how far those two lie apart.
struct SpikeMeasure {
  double height = 0, between = 0;
};
SpikeMeasure MeasureSpike(const SensorTrack& track, std::size_t first, std::size_t width);

/// Whether a block stands out so much more than its neighbours differ that no motion made it.
bool IsSpike(const SpikeMeasure& measure, std::size_t width, double threshold);

}  // namespace morphograph
