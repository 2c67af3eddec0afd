#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

struct LocallyLinearEmbeddingOptions {
  int neighbours = 12;            // of each sample, >= 2; fewer where there are fewer samples
  double regularisation = 1e-3;   // added to the neighbours' Gram matrix, times its trace; > 0
  int components = 2;             // >= 1
};

/// Locally linear embedding (Roweis & Saul 2000; Xie 5.1.3): coordinates in which every sample is the same weighted mean of its neighbours
/// as it is in the data.
struct LocallyLinearEmbedding {
  LocallyLinearEmbeddingOptions options;
  Eigen::MatrixXd samples;      // (D x N)
  Eigen::MatrixXd coordinates;  // (components x N), mean 0, mean squares 1, uncorrelated; signs: the largest entry is positive
  Eigen::VectorXd eigenvalues;  // (components), of each coordinate: what its neighbours leave unexplained, smallest first
  /// Pieces into which the neighbourhoods fall. With more than one, the first coordinates say only which piece a sample is in.
  int pieces = 1;

  int components() const { return static_cast<int>(coordinates.rows()); }

  /// Out of sample: the coordinates' mean with the weights that best make `sample` of its nearest samples (Saul & Roweis 2003, 6.1).
  /// It is continuous but for changes of neighbours. A training sample comes out as the mean of others, not at its own coordinates,
  /// unless it is its own neighbour, as here. @throws std::invalid_argument when the size differs.
  Eigen::VectorXd Embed(const Eigen::VectorXd& sample) const;
  /// Back: the samples' mean with the weights that best make `coordinate` of the nearest coordinates.
  Eigen::VectorXd Reconstruct(const Eigen::VectorXd& coordinate) const;
};

/// Weights (sum 1, may be negative) with which columns of `neighbours` come closest to `point`, least |point - neighbours w|^2 + r |w|^2
/// with r = regularisation times the trace of the Gram matrix of neighbours - point.
/// @param neighbours  (D x k), k >= 1. @throws std::invalid_argument for sizes that differ or a regularisation that is not positive.
Eigen::VectorXd ReconstructionWeights(const Eigen::VectorXd& point, const Eigen::MatrixXd& neighbours, double regularisation);

/// Positions of the `count` columns nearest to `point`, nearest first, the first of equals; `skip` (or -1) is left out.
std::vector<int> NearestColumns(const Eigen::MatrixXd& columns, const Eigen::VectorXd& point, int count, int skip = -1);

/// Fits the embedding: reconstruction weights W of each sample, then the eigenvectors of (I - W)^T (I - W) with the smallest eigenvalues
/// but for the constant one, by shift and invert Lanczos on the sparse matrix (Spectra).
///
/// @param samples  (D x N), finite, scaled so that Euclidean distances mean something. N >= components + 2.
/// @throws std::invalid_argument naming the option or size at fault; std::runtime_error when the eigen solver does not converge.
LocallyLinearEmbedding FitLocallyLinearEmbedding(const Eigen::MatrixXd& samples, const LocallyLinearEmbeddingOptions& options = {});

}  // namespace morphograph
