#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// Joints of one stretch of motion at evenly spaced phases of it: (3 x (joints * phases)), metres; the evaluation's joints
/// (EvaluationRoles()) that the skeleton has, those of one phase after the other.
using JointSamples = Eigen::Matrix3Xf;

enum class SampleFrame {
  kWorld,
  kBody,  // origin on the floor below the root, +Z where the pelvis heads, at each phase anew
};

/// @param phases  2 or more; the first falls on frame `from`, the last on `to`, those between on places between two frames.
/// @throws std::invalid_argument unless 0 <= from <= to < frame_count.
JointSamples SampleJoints(const MotionClip& clip, int from, int to, int phases, SampleFrame frame);

/// How far motions lie apart: the mean over all pairs, joints and phases of the distance between the same joint at the same phase, metres.
/// 0 for fewer than two. @throws std::invalid_argument when sizes differ.
double MeanPairwiseJointDistance(const std::vector<JointSamples>& samples);

}  // namespace morphograph
