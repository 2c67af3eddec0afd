#pragma once

#include <vector>

#include "synthesis/control/control_measure.h"

namespace morphograph {

/// Lets arms and head finish what the walk has brought near: the points, orientations and views that the request's constraints ask of them.
/// @return how many poses were worked out on the way.
int ApplyPoseGoals(const ControlProblem& problem, const std::vector<double>& keyframe_times_s, MotionClip* clip);

}  // namespace morphograph
