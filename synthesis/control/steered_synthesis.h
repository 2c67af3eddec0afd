#pragma once

#include <random>

#include "synthesis/control/walk_optimizer.h"

namespace morphograph {

/// Draws a walk that does what the request's control terms ask: searched over the graph, optimised, measured on the finished clip. A walk
/// that misses a term is not given out; another is drawn, a few times.
/// @throws UnsatisfiableRequest naming every term that no walk has met, with what could be had instead.
SteeredWalk SteerWalk(const MotionGraph& graph, const SynthesisRequest& request, int style, double frame_rate_hz, std::mt19937_64& rng);

}  // namespace morphograph
