#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/primitive_fit.h"
#include "graph/training_set.h"
#include "primitives/manner_model.h"

namespace morphograph {

/// The steps of a primitive, as a manner is learned from them.
struct MannerSteps {
  Eigen::MatrixXd whitened;  // (D x n) latents, each whitened by its mixture component
  std::vector<int> component;  // (n) its mixture component
  Eigen::VectorXd component_weights;  // (mixture components) that the mixture gives them, sum 1
  std::vector<int> walk;     // (n) captured walk of each, in [0, walks)
  std::vector<int> ordinal;  // (n) number of the step in its walk
  std::vector<double> seconds;  // (n) duration
  int walks = 0;
};

struct MannerFitOptions {
  int far_steps = 4;        // steps this far apart share nothing but the manner; a step's turn is over by then
  int fewest_far_pairs = 40;  // fewer: pairs of `near_steps` and more have to do
  int near_steps = 2;
  int fewest_pairs = 10;    // fewer of these: no manner
  double largest_share = 0.9;
};

/// Fits a manner: b from the covariance of steps far apart in one walk (taken where it is over twice its standard error, else 0), and for
/// each walk the best linear prediction from the mean of its n steps, b / (b + (1 - b) / n) times that mean. Empty with too few steps.
MannerModel FitManner(const MannerSteps& steps, const MannerFitOptions& options = {});

/// Learns the manner of every primitive of a set, from its steady steps; the walks of a style are its captured clips. Bent copies teach
/// none: a path that is bent for long is not a manner of walking. Manners of a style have mean 0, walks weighted by their steps.
/// @param fitted  in the order of the set's classes; `manner` and `manners` are set.
void FitManners(const TrainingSet& set, std::vector<FittedPrimitive>* fitted);

}  // namespace morphograph
