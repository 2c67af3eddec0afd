#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// World transforms of every joint of one frame.
struct WorldPose {
  Eigen::Matrix3Xd positions;                  // (3 x joints), metres
  std::vector<Eigen::Quaterniond> rotations;   // world_from_joint
};

/// Fills `pose` (resized as needed) from local rotations.
///
/// @param rotations  `joint_count()` unit quaternions, parent_from_joint.
/// @param root_position  of the moving root, metres.
void ForwardKinematics(const Skeleton& skeleton, const Eigen::Quaterniond* rotations,
                       const Eigen::Vector3d& root_position, WorldPose* pose);
WorldPose ForwardKinematics(const MotionClip& clip, int frame);

/// Poses of a whole clip, one a frame.
std::vector<WorldPose> WorldPoses(const MotionClip& clip);

/// Joint positions of a whole clip: one matrix (3 x joints) a frame.
std::vector<Eigen::Matrix3Xd> JointPositions(const MotionClip& clip);

}  // namespace morphograph
