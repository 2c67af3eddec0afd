#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/placements.h"
#include "datasets/sensor_alignment.h"
#include "tests/benchmarks/real_sensors.h"

namespace morphograph {

/// How a segment's own frame lies in its body's directions (left, up, forwards), and where the joint that it hangs on is.
struct SegmentAnatomy {
  Eigen::Matrix3d segment_from_body = Eigen::Matrix3d::Zero();
  Eigen::Vector3d joint = Eigen::Vector3d::Zero();  // in the segment's frame
};

/// Of the person, by markers: feet while they stand flat, the rest while the person walks.
SegmentAnatomy AnatomyOf(const BodySensor& sensor, const NeuraRecording& neura, const SegmentMotion& segment);

/// Of a joint of recorded clips, by role.
SegmentAnatomy AnatomyOf(const std::string& joint_name, const std::vector<MotionClip>& clips);

/// Where the sensor sits on the model's body, by where it sits on the person's. @param scale  of the model's lengths to the person's.
Placement PlacementOf(const BodySensor& sensor, const SensorAlignment& alignment, const SegmentAnatomy& person, const SegmentAnatomy& model, double scale);

}  // namespace morphograph
