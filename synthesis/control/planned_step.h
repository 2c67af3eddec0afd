#pragma once

#include <memory>

#include "synthesis/control/step_kinematics.h"
#include "synthesis/graph_walk.h"

namespace morphograph {

/// A walk that is being searched for, by its last step. Walks share the steps that they have in common; those that nobody goes on with go away.
struct PlannedStep {
  std::shared_ptr<const PlannedStep> before;
  WalkStep step;
  KeyframePlace place = KeyframePlace::Zero(), next = KeyframePlace::Zero();  // where the step begins and ends
  double along = 0;           // on the path, at its end
  double cost = 0;            // of what has been walked
  double estimate = 0;        // of what lies ahead
  int steps = 1;
  int lags = 0;               // steps since it last came a stretch of the way farther
  int contacts[2] = {0, 0};   // planted intervals that each foot has begun by the step's end
  double end_s = 0;           // of the clip, once the walk is over
};
using PlannedWalk = std::shared_ptr<const PlannedStep>;

}  // namespace morphograph
