#pragma once

#include <Eigen/Core>
#include <vector>

#include "synthesis/evaluation_motion.h"

namespace morphograph {

/// Windows of METHODS section 6: 15 frames at 30 fps, every third of them kept, a window every 7 frames.
struct PoseWindowOptions {
  int frames = 15;
  int stride = 3;
  int hop = 7;
};

/// Pose features of every frame, (44 x frames): the 14 evaluation roles in metres (x to the left, y up from
/// the clip's ground, z forward; relative to the hips on the floor, turned to the pelvis' heading), then the
/// hips' planar velocity (left, forward) in m/s by central differences, one-sided at the ends. Neither
/// heading nor floor position matters.
/// @throws std::invalid_argument when an evaluation role is missing or there are fewer than 2 frames.
Eigen::MatrixXd PoseFeatures(const EvaluationMotion& motion);

/// Windows of a clip, (220 x windows): the features of the kept frames, one under the other, in time order.
/// No column when the clip is shorter than a window. @throws as PoseFeatures, or for options that are not
/// positive.
Eigen::MatrixXd PoseWindows(const EvaluationMotion& motion, const PoseWindowOptions& options = {});

/// Matrices of equal height side by side. @throws std::invalid_argument when heights differ or nothing is
/// given.
Eigen::MatrixXd JoinColumns(const std::vector<Eigen::MatrixXd>& parts);

}  // namespace morphograph
