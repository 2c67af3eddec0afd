#pragma once

#include <vector>

#include "graph/shared_margin.h"
#include "graph/training_variant.h"
#include "graph/transition_model.h"
#include "primitives/gaussian_mixture.h"

namespace morphograph {

struct TransitionFitOptions {
  TrainingVariant::Transition form = TrainingVariant::Transition::kStationary;
  double largest_gain = 0.97;   // singular values of the linear part stay below
  double smallest_noise = 0.02; // eigenvalues of the noise covariance stay above (whitened units)
  double chance_prior = 1.0;    // pseudo-counts of the component chain, spread by the target's component weights
  int min_pairs_for_process = 5;
  /// Whether the pairs are all that is known of the target, so that its marginal is to be kept. If not, as for the steps after a
  /// start, which still gather speed, residuals stay as they are.
  bool keep_marginal = true;
  /// Of the two primitives; A begins with what it says, where that predicts unseen clips better. Empty: nothing is known of it.
  SharedMargin margin = {};
  double process_gain = 0.02;   // part of A's error on unseen clips that the RBF part has to take away to be kept
};

/// Fits a transition to pairs of latents that follow each other in the capture (see TransitionModel).
/// @throws std::invalid_argument without pairs or with sizes that do not fit the mixtures.
TransitionModel FitTransition(const TransitionPairs& pairs, const GaussianMixture& source, const GaussianMixture& target,
                              const TransitionFitOptions& options = {});

}  // namespace morphograph
