#pragma once

#include <Eigen/Core>
#include <limits>

namespace morphograph {

struct WeightedPcaOptions {
  double variance_kept = 0.99;  // fraction of the weighted variance, (0, 1]
  int max_components = std::numeric_limits<int>::max();
};

/// Weighted principal components: x ~ mean + basis z (Du 3.3.2).
///
/// The basis is orthonormal in the weighted inner product, basis^T diag(weights) basis = I, and latents are
/// uncorrelated over the samples, with the given variances.
struct WeightedPca {
  Eigen::VectorXd mean;       // (D)
  Eigen::MatrixXd basis;      // (D x k)
  Eigen::VectorXd weights;    // (D) >= 0, on squared deviations
  Eigen::VectorXd variances;  // (k), largest first; mean squares over the samples (1 / N)
  double variance_kept = 1;   // fraction of the weighted variance, (0, 1]

  int dimension() const { return static_cast<int>(mean.size()); }
  int components() const { return static_cast<int>(basis.cols()); }

  /// Latent (k) of a sample (D): the one whose reconstruction is nearest in the weighted norm.
  /// @throws std::invalid_argument when the size differs; so does Reconstruct.
  Eigen::VectorXd Project(const Eigen::VectorXd& sample) const;
  Eigen::MatrixXd ProjectAll(const Eigen::MatrixXd& samples) const;  // (D x N) to (k x N)
  /// Sample (D) of a latent (k).
  Eigen::VectorXd Reconstruct(const Eigen::VectorXd& latent) const;
};

/// Fits weighted PCA by the generalised SVD (Du Eq. 3.24-3.28 with Omega = I, Phi = diag(weights)), least in
/// sum_ij weights[i] (x_ij - reconstruction_ij)^2: thin SVD of diag(weights)^(1/2) (X - mean), scaled back.
///
/// Signs are fixed so that the largest entry of each weighted axis is positive. A dimension of weight 0 has no say in
/// the latents; it is reconstructed by regression on them. Directions without variance (beyond rounding) give no component,
/// so equal samples, or one, give none.
///
/// @param samples  (D x N), N >= 1, finite.
/// @param weights  (D), finite, >= 0; a scale s on a coordinate is the weight s^2.
/// @throws std::invalid_argument naming the weight, size or option at fault.
WeightedPca FitWeightedPca(const Eigen::MatrixXd& samples, const Eigen::VectorXd& weights,
                           const WeightedPcaOptions& options = {});

}  // namespace morphograph
