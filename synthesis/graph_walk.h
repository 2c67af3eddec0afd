#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "graph/motion_graph.h"
#include "synthesis/walk_manner.h"

namespace morphograph {

/// One step of a walk over the graph.
struct WalkStep {
  int primitive = 0;
  int edge = -1;              // that led here; -1 for the first
  int change = -1;            // of the graph's changes, where this step begins as one of another action; `edge` then led to that one
  int component = 0;          // of the primitive's mixture
  Eigen::VectorXd whitened;   // latent, whitened by that component
  Eigen::VectorXd latent;
  WalkManner manner;          // of the walk, at this step
  bool gathers_speed = false; // the step after a start: not a steady one, whatever its primitive
  double log_likelihood = 0;  // of this step given the one before
};

/// Draws the manner of a walk and, from the mixture prior of a primitive, its first step.
WalkStep DrawFirstStep(const MotionGraph& graph, int primitive, std::mt19937_64& rng);

/// Draws the step that follows over an edge: transition and prior together (METHODS section 3, see TransitionModel).
///
/// A step stays within what its primitive has seen. Not so the step after a start: that one is learned from captured second steps, which
/// still gather speed and lie far outside of the steady ones; it stays near those that its transition has seen. The one after that is another walker's
/// where the walk's own would leap into his stride.
WalkStep DrawNextStep(const MotionGraph& graph, const WalkStep& previous, int edge, std::mt19937_64& rng);

}  // namespace morphograph
