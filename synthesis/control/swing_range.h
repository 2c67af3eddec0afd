#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "synthesis/control/step_kinematics.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {

/// How the ball of the foot that a step puts down swings, at canonical phases over the step: its speed from one to the next, and its height, with derivatives by the
/// step's whitened latent w (D). They do not depend on where the step is.
struct SwingState {
  Eigen::VectorXd speed_m_s, height_m;            // (kSwingSpans)
  Eigen::MatrixXd speed_by_latent, height_by_latent;  // (kSwingSpans x D)
};
inline constexpr int kSwingSpans = 9;
SwingState SwingOf(const StepKinematics& step, const JointChain& ball, const Eigen::VectorXd& w);

/// What swings of a kind of step keep to: 99 of 100 swing more slowly, and 99 of 100 lower.
///
/// Speed and height at a phase are taken as normal, as they are to first order in a latent that is N(0, I). True ones have a longer tail, which captured ones lack: these bounds are
/// within some percent of what 99 of 100 captured steps keep to.
struct SwingRange {
  double speed_m_s = 0, height_m = 0;
  double speed_deviation_m_s = 1, height_deviation_m = 1;  // at the phase that has the bound
};
SwingRange SwingRangeOf(const StepKinematics& step, const JointChain& ball);

/// The fastest and the highest that the ball of the foot that lands comes in a step of a clip.
struct ClipSwing {
  double speed_m_s = 0, height_m = 0;
};
/// @param from, to  first and last frame of the step, within the clip.
ClipSwing SwingInClip(const MotionClip& clip, Foot foot, int from, int to);

}  // namespace morphograph
