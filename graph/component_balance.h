#pragma once

#include <vector>

#include "graph/motion_graph.h"
#include "graph/primitive_fit.h"

namespace morphograph {

/// Makes steady walks meet every mixture component as often as captured ones do.
///
/// Which component the next step belongs to depends on the one before (TransitionModel::component_chances) and on the manner of the walk
/// (MannerModel::components); each is right by itself, but together they meet some components too often: walks that turn much turn ever
/// more. For every captured walk's manner the stationary distribution of components is worked out. Its factors are scaled until that is what the walk itself
/// has met; then the chances of entering a component, until the mean over the walks is the mixture's weight, which moves single walks a little again.
/// @param fitted  MannerModel::components of its steady primitives are changed.
void BalanceComponents(std::vector<FittedPrimitive>* fitted, std::vector<GraphEdge>* edges);

}  // namespace morphograph
