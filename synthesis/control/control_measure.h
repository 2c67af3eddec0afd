#pragma once

#include <vector>

#include "datasets/forward_kinematics.h"
#include "synthesis/control/control_problem.h"

namespace morphograph {

/// A finished clip with what terms are measured on.
struct MeasuredClip {
  const MotionClip& clip;
  std::vector<PlantedFoot> contacts;

  int FrameAt(double time_s) const;
  Eigen::Vector2d RootAt(int frame) const;
  double HeadingAt(int frame) const;
};

/// The frame that a moment means, given the times of key frames (s); the clip's last frame bounds it.
int FrameOf(const ControlMoment& moment, const std::vector<double>& keyframe_times_s, const MeasuredClip& clip);

/// What became of every term: path, goal, goal's heading and speed first, then the constraints in order.
std::vector<ControlOutcome> MeasureControls(const ControlProblem& problem, const std::vector<double>& keyframe_times_s, const MeasuredClip& clip);

/// The foot's planted interval that a term means; null where the clip has fewer.
const PlantedFoot* FootstepOf(const FootstepTerm& term, const std::vector<PlantedFoot>& contacts);

}  // namespace morphograph
