#include "primitives/locally_linear_embedding.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>
#include <Spectra/MatOp/SparseSymShiftSolve.h>
#include <Spectra/SymEigsShiftSolver.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

// Number of parts that do not touch, neighbours taken both ways.
int CountPieces(const std::vector<std::vector<int>>& neighbours) {
  std::vector<int> leader(neighbours.size());
  std::iota(leader.begin(), leader.end(), 0);
  const auto find = [&](int i) {
    while (leader[i] != i) i = leader[i] = leader[leader[i]];
    return i;
  };
  int pieces = static_cast<int>(neighbours.size());
  for (size_t i = 0; i < neighbours.size(); ++i) {
    for (const int j : neighbours[i]) {
      const int a = find(static_cast<int>(i)), b = find(j);
      if (a != b) leader[a] = b, --pieces;
    }
  }
  return pieces;
}

Eigen::VectorXd WeightedMeanOf(const Eigen::MatrixXd& columns, const std::vector<int>& which, const Eigen::VectorXd& weights) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(columns.rows());
  for (size_t i = 0; i < which.size(); ++i) mean += weights[static_cast<Eigen::Index>(i)] * columns.col(which[i]);
  return mean;
}

// `point` made of its nearest columns of `from`, and the same mean of the columns of `to`.
Eigen::VectorXd Carry(const Eigen::MatrixXd& from, const Eigen::MatrixXd& to, const Eigen::VectorXd& point,
                      const LocallyLinearEmbeddingOptions& options, const char* what) {
  if (point.size() != from.rows())
    throw std::invalid_argument(std::string("LocallyLinearEmbedding: ") + what + " of size " + std::to_string(point.size()) + ", not " +
                                std::to_string(from.rows()));
  const std::vector<int> nearest = NearestColumns(from, point, options.neighbours);
  const Eigen::MatrixXd neighbours = from(Eigen::all, nearest);
  return WeightedMeanOf(to, nearest, ReconstructionWeights(point, neighbours, options.regularisation));
}

}  // namespace

Eigen::VectorXd ReconstructionWeights(const Eigen::VectorXd& point, const Eigen::MatrixXd& neighbours, double regularisation) {
  if (neighbours.rows() != point.size() || neighbours.cols() < 1)
    throw std::invalid_argument("ReconstructionWeights: neighbours (" + std::to_string(neighbours.rows()) + " x " +
                                std::to_string(neighbours.cols()) + ") of a point of size " + std::to_string(point.size()));
  if (!(regularisation > 0)) throw std::invalid_argument("ReconstructionWeights: regularisation must be > 0");
  const Eigen::MatrixXd apart = neighbours.colwise() - point;
  Eigen::MatrixXd gram = apart.transpose() * apart;
  // Neighbours that all lie on the point leave no say: then equal weights.
  const double ridge = std::max(regularisation * gram.trace(), 1e-300);
  gram.diagonal().array() += ridge;
  const Eigen::LLT<Eigen::MatrixXd> factor(gram / ridge);
  if (factor.info() != Eigen::Success) throw std::runtime_error("ReconstructionWeights: the Gram matrix cannot be factored");
  const Eigen::VectorXd weights = factor.solve(Eigen::VectorXd::Ones(neighbours.cols()));
  return weights / weights.sum();
}

std::vector<int> NearestColumns(const Eigen::MatrixXd& columns, const Eigen::VectorXd& point, int count, int skip) {
  std::vector<std::pair<double, int>> all;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    if (i != skip) all.emplace_back((columns.col(i) - point).squaredNorm(), static_cast<int>(i));
  }
  const auto kept = std::min<size_t>(all.size(), static_cast<size_t>(std::max(count, 0)));
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end());
  std::vector<int> nearest;
  for (size_t i = 0; i < kept; ++i) nearest.push_back(all[i].second);
  return nearest;
}

Eigen::VectorXd LocallyLinearEmbedding::Embed(const Eigen::VectorXd& sample) const {
  return Carry(samples, coordinates, sample, options, "sample");
}

Eigen::VectorXd LocallyLinearEmbedding::Reconstruct(const Eigen::VectorXd& coordinate) const {
  return Carry(coordinates, samples, coordinate, options, "coordinate");
}

LocallyLinearEmbedding FitLocallyLinearEmbedding(const Eigen::MatrixXd& samples, const LocallyLinearEmbeddingOptions& options) {
  const int count = static_cast<int>(samples.cols());
  const auto fail = [](const std::string& what) { throw std::invalid_argument("FitLocallyLinearEmbedding: " + what); };
  if (options.neighbours < 2) fail(std::to_string(options.neighbours) + " neighbours; at least 2");
  if (options.components < 1) fail(std::to_string(options.components) + " components; at least 1");
  if (!(options.regularisation > 0) || !std::isfinite(options.regularisation)) fail("regularisation must be > 0");
  if (count < options.components + 2)
    fail(std::to_string(count) + " samples for " + std::to_string(options.components) + " components; two more samples are needed");
  if (!samples.allFinite()) fail("samples are not finite");

  LocallyLinearEmbedding embedding;
  embedding.options = options;
  embedding.samples = samples;
  std::vector<std::vector<int>> neighbours(count);
  std::vector<Eigen::Triplet<double>> entries;  // of I - W
  for (int i = 0; i < count; ++i) {
    neighbours[i] = NearestColumns(samples, samples.col(i), options.neighbours, i);
    const Eigen::VectorXd weights = ReconstructionWeights(samples.col(i), samples(Eigen::all, neighbours[i]), options.regularisation);
    entries.emplace_back(i, i, 1.0);
    for (size_t n = 0; n < neighbours[i].size(); ++n) entries.emplace_back(i, neighbours[i][n], -weights[static_cast<Eigen::Index>(n)]);
  }
  embedding.pieces = CountPieces(neighbours);
  SparseMatrix residual(count, count);
  residual.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix matrix = residual.transpose() * residual;

  // The matrix is singular (constant vectors), so the shift lies a little below zero.
  const int wanted = options.components + 1;
  const double shift = -1e-9 * std::max(matrix.diagonal().mean(), 1e-30);
  Spectra::SparseSymShiftSolve<double> inverse(matrix);
  Spectra::SymEigsShiftSolver<Spectra::SparseSymShiftSolve<double>> solver(inverse, wanted, std::min(count, std::max(2 * wanted + 1, 20)),
                                                                          shift);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-10, Spectra::SortRule::SmallestAlge);
  if (solver.info() != Spectra::CompInfo::Successful)
    throw std::runtime_error("FitLocallyLinearEmbedding: the eigen solver found " + std::to_string(solver.eigenvalues().size()) + " of " +
                             std::to_string(wanted) + " eigenvectors");
  // By the spectrum of M, whatever the solver's order; the first is the constant one (one of them where there are several pieces).
  std::vector<int> order(wanted);
  std::iota(order.begin(), order.end(), 0);
  const Eigen::VectorXd values = solver.eigenvalues();
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  Eigen::MatrixXd vectors = solver.eigenvectors()(Eigen::all, order);
  embedding.eigenvalues.resize(options.components);
  embedding.coordinates.resize(options.components, count);
  for (int c = 0; c < options.components; ++c) {
    embedding.eigenvalues[c] = std::max(values[order[c + 1]], 0.0);
    Eigen::VectorXd axis = vectors.col(c + 1);
    axis.array() -= axis.mean();
    axis *= std::sqrt(static_cast<double>(count)) / std::max(axis.norm(), 1e-12);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    embedding.coordinates.row(c) = (axis[largest] < 0 ? -1 : 1) * axis.transpose();
  }
  return embedding;
}

}  // namespace morphograph
