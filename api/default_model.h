#pragma once

#include <memory>

#include "graph/motion_graph.h"

namespace morphograph {

/// The model embedded in the program (datasets/models/walk.mgm), parsed anew; null in a program built without one.
std::shared_ptr<const MotionGraph> LoadDefaultModel();

}  // namespace morphograph
