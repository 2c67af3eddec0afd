#pragma once

#include "graph/motion_graph.h"
#include "synthesis/synthesis_types.h"
#include "synthesis/synthesis_variant.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {

/// Draws a new clip from the graph (METHODS section 3): a legal walk over the graph, each step's vector from prior and
/// transition together, joined over the shared margins, planted feet locked.
///
/// Pure: same graph and request give the same clip, on any thread. Safe to call from many threads at once.
/// @throws std::invalid_argument on `request.FirstProblem()`; UnsatisfiableRequest for an unknown style, and for a
///   start or an end that the model has not learned.
SynthesisResult Synthesize(const MotionGraph& graph, const SynthesisRequest& request, const SynthesisVariant& variant = {});

}  // namespace morphograph
