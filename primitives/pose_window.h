#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/joint_roles.h"
#include "datasets/motion_clip.h"

namespace morphograph {

/// The joints of EvaluationRoles in every frame (each 3 x joints, world), in leg lengths, so that bodies of any size compare.
/// @throws std::invalid_argument when the clip lacks one of these roles or has no leg bones.
std::vector<Eigen::Matrix3Xd> ScaledPoses(const MotionClip& clip);

/// The column of such a pose that holds a joint, one of EvaluationRoles.
Eigen::Index PoseColumn(JointRole role);

/// The poses in a mirror: x changes sign, left and right joints change places.
std::vector<Eigen::Matrix3Xd> MirroredPoses(const std::vector<Eigen::Matrix3Xd>& poses);

/// Three poses side by side (3 x 3 joints): `reach_frames` before `frame`, at it, and as far after it, between frames by
/// linear interpolation; beyond the ends the last change goes on. The lowest joint has height 0: floors may tilt.
Eigen::Matrix3Xd PoseWindow(const std::vector<Eigen::Matrix3Xd>& poses, double frame, double reach_frames);

/// Weights of a window's points (sum 1) that tell windows of some kinds from any other: scatter over all windows over scatter
/// within a kind, less one. A joint that does the same anyhow, and one that does anything at a key frame, weigh nothing.
/// This is Fisher's criterion for each point on its own, after turning windows to face +Z.
///
/// @param kinds  windows of each kind, at least one in all.
/// @param all  windows at all times.
Eigen::VectorXd DiscriminantWeights(const std::vector<std::vector<Eigen::Matrix3Xd>>& kinds,
                                    const std::vector<Eigen::Matrix3Xd>& all);

}  // namespace morphograph
