#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/readings.h"

namespace morphograph {

/// How a segment of the body moved: metres, Y up, a column a sample.
struct SegmentMotion {
  double rate_hz = 0;
  std::vector<Eigen::Matrix3d> rotations;  // world_from_segment
  Eigen::Matrix3Xd positions;              // of the segment's origin

  int sample_count() const { return static_cast<int>(positions.cols()); }
};

/// Segment frames from markers fixed to one segment: the mean shape of the markers, laid over each sample's by Kabsch's method (Umeyama's without scale). The origin is
/// the markers' middle.
/// @param markers  steady and all finite (RepairStream()), metres, Y up.
/// @throws std::invalid_argument for fewer than 3 names, a name that is not there, markers on a line, or lost values.
SegmentMotion SegmentFromMarkers(const Readings& markers, const std::vector<std::string>& names);

/// The frame of a joint of a clip.
SegmentMotion SegmentOfJoint(const MotionClip& clip, int joint);

/// How a sensor sits on a segment.
struct SensorAlignment {
  Eigen::Quaterniond segment_from_sensor = Eigen::Quaterniond::Identity();
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  // lever arm: from the segment's origin, in its frame
  int delay_samples = 0;                               // the sensor's samples come this much later
};

struct SensorAlignmentOptions {
  double cutoff_hz = 10;        // of the low-pass of both sides
  int rounds = 10;                 // 1 or more
  int most_delay_samples = 10;  // looked for in both directions
  double least_standing_s = 0.5;
};

/// Finds how a sensor sits on a segment whose motion is known beside the sensor (from markers, or a clip).
///
/// The delay starts where the lengths of both accelerations correlate best, and goes to the neighbouring one as long as that leaves a smaller residual. At each delay, gravity in a standing phase gives the tilt, the yaw about it is the closed-form best over the rest (without a standing
/// phase: Wahba's problem over all samples). Then, by turns: the rotation that solves Wahba's problem between readings and a = R^T (p'' - g) + R^T R'' o, and the lever arm o of linear least
/// squares.
/// @param accelerations  (3 x samples) of the sensor, at the segment's rate, started with it.
/// @throws std::invalid_argument for fewer than 50 samples or values that are not finite.
SensorAlignment AlignSensor(const SegmentMotion& segment, const Eigen::Matrix3Xd& accelerations, const SensorAlignmentOptions& options = {});

/// What the sensor would read: a = C^T (R^T (p'' - g) + R^T R'' o), second differences over three samples, low-passed as both sides of the alignment are.
Eigen::Matrix3Xd ReadingsOf(const SegmentMotion& segment, const SensorAlignment& alignment, double cutoff_hz);

struct AlignmentQuality {
  double residual_m_s2 = 0;  // root mean square length of the difference between reading and segment's motion
  double correlation = 0;    // of both, over the three axes together, means taken out
};

/// Compares over samples [first, last] of the segment. @throws std::invalid_argument for a range outside of the samples.
AlignmentQuality MeasureAlignment(const SegmentMotion& segment, const Eigen::Matrix3Xd& accelerations, const SensorAlignment& alignment, int first, int last, double cutoff_hz = 10);

/// The rotation that takes `from` nearest to `to`, both (3 x n), about the origin: Wahba's problem by singular values (Markley 1988).
Eigen::Matrix3d BestRotation(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// By how many samples `later` lags behind `reference`: the shift within +-`most` at which they correlate best (means taken out). Rows are channels.
int DelayByCorrelation(const Eigen::MatrixXd& reference, const Eigen::MatrixXd& later, int most);

/// How a sensor is turned against a reference of the same place on another body or at another time, whose samples do not correspond: the means (gravity, mostly) are laid over each other, then the yaw about
/// them is the one of a degree's grid at which second and third moments agree best (a walk is not the same forwards and backwards).
/// @return reference_from_sensor. @throws std::invalid_argument without samples.
Eigen::Quaterniond MountingByMoments(const Eigen::Matrix3Xd& reference, const Eigen::Matrix3Xd& sensor);

}  // namespace morphograph
