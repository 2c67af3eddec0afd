#include "synthesis/control/kinematics_cache.h"

namespace morphograph {

KinematicsCache::Entry& KinematicsCache::Made(const WalkStep& step) {
  for (Entry& entry : made_) {
    if (entry.primitive == step.primitive && entry.component == step.component) return entry;
  }
  const MotionPrimitive& primitive = graph_.primitive(step.primitive);
  const Eigen::Quaterniond& mean = graph_.styles()[static_cast<size_t>(primitive.style_index)].mean_rotations[static_cast<size_t>(graph_.layout().active_joints()[0])];
  const auto model = std::make_shared<StepModel>(primitive, step.component);
  return made_.emplace_back(Entry{step.primitive, step.component, std::make_shared<StepKinematics>(model, graph_.layout(), mean), {}});
}

const SwingRange& KinematicsCache::SwingsOf(const WalkStep& step, const JointChain& ball) {
  Entry& entry = Made(step);
  if (!entry.swings) entry.swings = SwingRangeOf(*entry.kinematics, ball);
  return *entry.swings;
}

}  // namespace morphograph
