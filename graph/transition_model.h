#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "graph/gaussian_process.h"
#include "primitives/gaussian_mixture.h"

namespace morphograph {

/// Training pairs of an edge: column i of `next` followed column i of `previous` in the capture.
struct TransitionPairs {
  Eigen::MatrixXd previous;  // (components of the source x pairs) latents
  Eigen::MatrixXd next;      // (components of the target x pairs)
};

/// From one step's latent to the next one's, keeping the captured marginal (METHODS section 3).
///
/// Both latents are whitened by the mixture component that they belong to. A Markov chain picks the next component; then
///   w' = A w + f(w) + e,
/// A by ridge regression, its singular values below 1; f a Gaussian process on what A leaves (Du 3.5); e a whole training residual,
/// recoloured to the covariance I - Cov(A w + f(w)), so that walking on for ever keeps each component's mean and covariance.
struct TransitionModel {
  double probability = 1;                 // empirical, of leaving the source by this edge
  int pairs = 0;
  Eigen::MatrixXd component_chances;      // (source components x target components), rows sum to 1
  Eigen::MatrixXf linear;                 // A, (E x D)
  std::optional<GaussianProcess> process;  // f; absent where the marginal likelihood prefers A alone
  Eigen::MatrixXf residuals;              // (E x pairs), recoloured
  std::vector<int> residual_component;    // target component of each residual
  Eigen::MatrixXd noise_cholesky;         // lower, of I - Cov(A w + f(w)), for densities
  double log_marginal_likelihood = 0;     // of the process, or of A with white noise
  double length_scale = 0, signal_variance = 0, noise_variance = 0;

  /// A w + f(w): mean of the next whitened latent.
  Eigen::VectorXd Mean(const Eigen::VectorXd& whitened) const;
};

}  // namespace morphograph
