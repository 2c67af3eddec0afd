#pragma once

#include <functional>
#include <random>

#include "graph/motion_graph.h"
#include "graph/walk_boundary.h"
#include "synthesis/graph_walk.h"

namespace morphograph {

/// A steady primitive that is no dead end: where a walk can be on its way.
bool WalksOn(const MotionGraph& graph, int primitive);
/// An edge leads from it into steady walking.
bool LeadsOn(const MotionGraph& graph, int primitive);

/// A walk of that style can begin with it.
bool IsFirst(const MotionGraph& graph, int style, WalkBoundary from, int primitive);

/// An edge out of `primitive` into one of those allowed, by probability; -1 where there is none.
int DrawEdge(const MotionGraph& graph, int primitive, const std::function<bool(int)>& allowed, std::mt19937_64& rng);

/// The first step of a walk of a style out of a boundary. Inside a walk it is drawn from the mixture and walked on for a few steps, so
/// that it is as much a product of the transitions as any other.
/// @param allowed  primitives that a walk may begin with.
/// @throws UnsatisfiableRequest ("/style") where the style has none.
WalkStep DrawStart(const MotionGraph& graph, int style, WalkBoundary from, const std::function<bool(int)>& allowed, std::mt19937_64& rng);

}  // namespace morphograph
