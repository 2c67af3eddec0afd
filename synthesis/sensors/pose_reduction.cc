#include "synthesis/sensors/pose_reduction.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "datasets/parallel_for.h"
#include "primitives/matrix_factors.h"

namespace morphograph {
namespace {

// Distances between poses that LLE compares are taken along so many principal components, which hold all but a thousandth of the variance.
constexpr int kLleInputs = 24;

}  // namespace

PoseReduction::PoseReduction(const Eigen::MatrixXf& poses, const PoseReductionOptions& options) : options_(options) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("PoseReduction: " + what); };
  if (options.components < 1) fail(std::to_string(options.components) + " components; at least 1");
  if (poses.cols() < 2) fail("fewer than 2 poses");
  options_.components = static_cast<int>(std::min<Eigen::Index>(options.components, poses.rows()));
  mean_ = poses.cast<double>().rowwise().mean();
  const Eigen::MatrixXf centred = poses.colwise() - mean_.cast<float>();
  const Eigen::MatrixXd covariance = (centred * centred.transpose()).cast<double>() / static_cast<double>(poses.cols());
  const SymmetricFactors factors = FactorSymmetric(covariance);
  const bool lle = options.kind == ReductionKind::kLle;
  const Eigen::Index kept = std::min<Eigen::Index>(lle ? std::max(kLleInputs, options_.components) : options_.components, poses.rows());
  axes_ = factors.vectors.rowwise().reverse().leftCols(kept);
  for (Eigen::Index c = 0; c < kept; ++c) {
    Eigen::Index largest = 0;
    axes_.col(c).cwiseAbs().maxCoeff(&largest);
    if (axes_(largest, c) < 0) axes_.col(c) *= -1;
  }
  spreads_ = factors.values.reverse().head(kept).cwiseMax(0).cwiseSqrt();
  if (!lle) return;
  if (options.samples < 10) fail("fewer than 10 samples to embed");
  const Eigen::Index count = std::min<Eigen::Index>(options.samples, poses.cols());
  Eigen::MatrixXd samples(kept, count);
  for (Eigen::Index i = 0; i < count; ++i) samples.col(i) = axes_.transpose() * centred.col(i * poses.cols() / count).cast<double>();
  LocallyLinearEmbeddingOptions how;
  how.neighbours = options.neighbours;
  how.regularisation = options.regularisation;
  how.components = options_.components;
  embedding_ = std::make_shared<LocallyLinearEmbedding>(FitLocallyLinearEmbedding(samples, how));
  spreads_ = Eigen::VectorXd::Ones(options_.components);  // by its definition
}

Eigen::MatrixXf PoseReduction::Coordinates(const Eigen::MatrixXf& poses, int jobs) const {
  const Eigen::MatrixXf along = axes_.cast<float>().transpose() * (poses.colwise() - mean_.cast<float>());
  if (!embedding_) return along;
  Eigen::MatrixXf coordinates(options_.components, poses.cols());
  ParallelFor(jobs, static_cast<int>(poses.cols()),
              [&](int i) { coordinates.col(i) = embedding_->Embed(along.col(i).cast<double>()).cast<float>(); });
  return coordinates;
}

Eigen::VectorXd PoseReduction::Pose(const Eigen::VectorXd& coordinates) const {
  if (embedding_) return mean_ + axes_ * embedding_->Reconstruct(coordinates);
  return mean_ + axes_ * coordinates;
}

}  // namespace morphograph
