#pragma once

#include <string>
#include <vector>

#include "graph/action_change.h"
#include "graph/primitive_fit.h"
#include "graph/training_set.h"

namespace morphograph {

/// Finds where walks of one action can go over into another (ActionChange): for each style that shows both and for either foot, whether
/// enough of the captured steps have a near enough one of the other action.
/// @param fitted  in the order of the set's classes, styles set.
/// @param notes  is told of every style and direction, also why there is none.
std::vector<ActionChange> FindActionChanges(const TrainingSet& set, const std::vector<FittedPrimitive>& fitted, const std::string& action,
                                            std::vector<std::string>* notes);

}  // namespace morphograph
