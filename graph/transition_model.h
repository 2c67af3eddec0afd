#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "graph/gaussian_process.h"
#include "primitives/gaussian_mixture.h"

namespace morphograph {

/// How the steps at one end of training pairs sit in their walks (see MannerModel).
struct PairManner {
  Eigen::VectorXd within_scale;  // (components) sqrt(1 - b); empty: no manner
  Eigen::MatrixXd manner;        // (components x pairs) m of each step's walk
};

/// Training pairs of an edge: column i of `next` followed column i of `previous` in the capture.
struct TransitionPairs {
  Eigen::MatrixXd previous;  // (components of the source x pairs) latents
  Eigen::MatrixXd next;      // (components of the target x pairs)
  /// Per pair the captured clip that it comes from, itself or by a mirrored or bent copy; pairs of one clip are never used to
  /// judge each other. Empty: every pair is on its own.
  std::vector<int> clip;
  std::vector<char> made;    // per pair: of a copy; empty: none is
  PairManner previous_manner = {}, next_manner = {};
};

/// From one step's latent to the next one's, keeping the captured marginal (METHODS section 3).
///
/// Both latents are whitened by the mixture component that they belong to, and what stays over a walk is taken out (MannerModel; w is
/// z there). A Markov chain picks the next component; then
///   w' = A w + f(w) + e,
/// A w + f(w) the mean of a Gaussian process (Du 3.5) with a linear and an RBF kernel, A (begun with what a SharedMargin says, singular
/// values below 1) and f its parts, f kept only where it predicts clips that it has not seen better than A alone; e a training residual of
/// unseen clips, recoloured to the covariance I - Cov(A w + f(w)) over w ~ N(0, I), so that walking on for ever keeps each
/// component's mean and covariance.
struct TransitionModel {
  double probability = 1;                 // empirical, of leaving the source by this edge
  int pairs = 0;
  Eigen::MatrixXd component_chances;      // (source components x target components), rows sum to 1
  Eigen::MatrixXf linear;                 // A, (E x D)
  std::optional<GaussianProcess> process;  // f; absent where A alone predicts unseen clips as well
  Eigen::MatrixXf residuals;              // (E x pairs), recoloured
  std::vector<int> residual_component;    // target component of each residual
  Eigen::MatrixXd noise_cholesky;         // lower, of I - Cov(A w + f(w)), for densities
  double log_marginal_likelihood = 0;     // of the Gaussian process in use
  /// Its kernel. Without an RBF part the signal variance is 0, and the length scale is the one that was tried.
  double length_scale = 0, signal_variance = 0, linear_variance = 0, noise_variance = 0;
  double unseen_error = 0;  // mean squared error on clips left out, in whitened units: 1 where the past tells nothing

  /// A w + f(w): mean of the next whitened latent.
  Eigen::VectorXd Mean(const Eigen::VectorXd& whitened) const;
};

}  // namespace morphograph
