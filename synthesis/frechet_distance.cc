#include "synthesis/frechet_distance.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "primitives/matrix_factors.h"

namespace morphograph {

GaussianFit FitGaussian(const Eigen::MatrixXd& samples) {
  if (samples.cols() < 2) {
    throw std::invalid_argument("FitGaussian: at least 2 samples are needed, not " +
                                std::to_string(samples.cols()));
  }
  if (!samples.allFinite()) throw std::invalid_argument("FitGaussian: a sample is not finite");
  GaussianFit fit;
  fit.mean = samples.rowwise().mean();
  const Eigen::MatrixXd centred = samples.colwise() - fit.mean;
  fit.covariance = centred * centred.transpose() / static_cast<double>(samples.cols() - 1);
  return fit;
}

double FrechetDistance(const GaussianFit& a, const GaussianFit& b) {
  if (a.mean.size() != b.mean.size() || a.covariance.rows() != b.covariance.rows()) {
    throw std::invalid_argument("FrechetDistance: dimensions differ, " + std::to_string(a.mean.size()) +
                                " and " + std::to_string(b.mean.size()));
  }
  const SymmetricFactors of_a = FactorSymmetric(a.covariance);
  // Rounding can leave eigenvalues of a singular covariance slightly below zero.
  const Eigen::VectorXd roots = of_a.values.cwiseMax(0.0).cwiseSqrt();
  const Eigen::MatrixXd root_a = of_a.vectors * roots.asDiagonal() * of_a.vectors.transpose();
  const Eigen::MatrixXd product = root_a * b.covariance * root_a;
  const SymmetricFactors of_product = FactorSymmetric(0.5 * (product + product.transpose()));
  const double cross = of_product.values.cwiseMax(0.0).cwiseSqrt().sum();
  const double squared =
      (a.mean - b.mean).squaredNorm() + a.covariance.trace() + b.covariance.trace() - 2 * cross;
  return std::max(0.0, squared);
}

}  // namespace morphograph
