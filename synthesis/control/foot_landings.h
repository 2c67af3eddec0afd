#pragma once

#include <Eigen/Core>
#include <optional>

#include "graph/motion_graph.h"
#include "synthesis/control/planned_step.h"
#include "synthesis/control/walk_guide.h"

namespace morphograph {

/// The foot that a step puts down at its end, 0 the left one; -1 for steps that come to a stand.
int LandingFoot(const MotionPrimitive& primitive);

/// Counts which foot stands as a walk begins: from a stand both; inside a walk the one that has just been put down, and maybe the one behind it.
void CountFirstContacts(const MotionGraph& graph, const WalkGuide& guide, PlannedStep* first);
/// Counts the foot that a step puts down after another.
void CountContacts(const MotionGraph& graph, const PlannedStep& before, PlannedStep* next);

/// Where a foot will be put down whose turn comes, if a walk goes on as in its last step.
struct Landing {
  Eigen::Vector2d position_m;
  double steps = 0;       // until then, from the step's end
  Eigen::Vector2d way_m;  // from there

  double deviation_m() const;  // the farther off, the less is known of it
};
/// @param begin, end  of the step, on the floor. @return nothing where the foot has been put down before.
std::optional<Landing> LandingOf(const MotionGraph& graph, const FootPlace& foot, const PlannedStep& step, const Eigen::Vector2d& begin, const Eigen::Vector2d& end);

}  // namespace morphograph
