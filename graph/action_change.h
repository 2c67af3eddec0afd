#pragma once

#include <string>

#include "primitives/step_blend.h"

namespace morphograph {

/// What a made step from one action into another takes.
struct ChangeEffort {
  double speed_m_s2 = 0;  // fastest change of step speed, from one step to the next
  double body_m_s2 = 0;   // HardestAcceleration_m_s2
};

/// A way from one action of a style into another: the made step left_walk_to_run, say. Recordings of one action each hold no such step. It is
/// put together from a step of each (BlendSteps) when it is needed, and only a walk that is asked to change takes it.
///
/// Made steps are allowed where they take no more than captured ones: speed changes from step to step no faster, and the body is accelerated
/// no harder, than at the most in captured steps of the two actions in that style.
struct ActionChange {
  std::string name;
  int from = 0;           // primitive whose step it begins as: it comes after what that one comes after
  int to = 0;             // primitive whose step it ends as: what comes after that one comes after it
  int examples = 0;       // captured steps of `from`
  int near_examples = 0;  // of these, how many have a captured step of `to` that is near enough
  ChangeEffort least;     // over the captured steps
  ChangeEffort captured;  // the most of captured steps, the limit for made ones
};

/// How fast speed changes over two steps: from the middle of one to the middle of the next.
double SpeedChange_m_s2(const StepShape& step, const StepShape& next);

/// Of a made step between steps like the two that it was made of.
ChangeEffort EffortOf(const StepShape& first, const StepShape& made, const StepShape& last, const Eigen::VectorXd& channel_weights);

inline bool IsWithin(const ChangeEffort& effort, const ChangeEffort& limit) {
  return effort.speed_m_s2 <= limit.speed_m_s2 && effort.body_m_s2 <= limit.body_m_s2;
}

/// How far apart two steps are that are to be made one: poses, and how far the difference in speed carries in half a step. Metres.
double ChangeDistance_m(const StepShape& first, const StepShape& last, const Eigen::VectorXd& channel_weights);

}  // namespace morphograph
