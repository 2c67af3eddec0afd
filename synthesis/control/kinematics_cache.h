#pragma once

#include <list>
#include <memory>
#include <optional>

#include "graph/motion_graph.h"
#include "synthesis/control/step_kinematics.h"
#include "synthesis/control/swing_range.h"
#include "synthesis/graph_walk.h"

namespace morphograph {

/// Makes StepKinematics once for every primitive and component of a style. For one thread.
class KinematicsCache {
 public:
  explicit KinematicsCache(const MotionGraph& graph) : graph_(graph) {}
  std::shared_ptr<const StepKinematics> Of(const WalkStep& step) { return Made(step).kinematics; }
  /// What swings of such steps keep to. @param ball  of the foot that they put down.
  const SwingRange& SwingsOf(const WalkStep& step, const JointChain& ball);

 private:
  struct Entry {
    int primitive, component;
    std::shared_ptr<const StepKinematics> kinematics;
    std::optional<SwingRange> swings;
  };
  Entry& Made(const WalkStep& step);

  const MotionGraph& graph_;
  std::list<Entry> made_;
};

}  // namespace morphograph
