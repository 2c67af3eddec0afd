#include "graph/action_change.h"

#include <algorithm>
#include <cmath>

namespace morphograph {

double SpeedChange_m_s2(const StepShape& step, const StepShape& next) {
  return std::abs(StepSpeed_m_s(next) - StepSpeed_m_s(step)) / (0.5 * (step.duration_s + next.duration_s));
}

ChangeEffort EffortOf(const StepShape& first, const StepShape& made, const StepShape& last, const Eigen::VectorXd& channel_weights) {
  return {std::max(SpeedChange_m_s2(first, made), SpeedChange_m_s2(made, last)), HardestAcceleration_m_s2(made, channel_weights)};
}

double ChangeDistance_m(const StepShape& first, const StepShape& last, const Eigen::VectorXd& channel_weights) {
  const double carried_m = (StepSpeed_m_s(last) - StepSpeed_m_s(first)) * 0.25 * (first.duration_s + last.duration_s);
  return std::hypot(PoseDistance_m(first, last, channel_weights), carried_m);
}

}  // namespace morphograph
