#pragma once

#include <memory>

#include "datasets/placements.h"
#include "synthesis/control/joint_chain.h"

namespace morphograph {

/// A sensor on a body whose joints are found by forward kinematics.
struct ChainedSensor {
  Placement place;
  std::shared_ptr<const JointChain> chain;
};

}  // namespace morphograph
