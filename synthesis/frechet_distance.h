#pragma once

#include <Eigen/Core>

namespace morphograph {

/// A normal distribution fitted to samples.
struct GaussianFit {
  Eigen::VectorXd mean;        // (D)
  Eigen::MatrixXd covariance;  // (D x D), divided by N - 1
};

/// @param samples  (D x N), a sample a column. @throws std::invalid_argument for N < 2 or values that are not
/// finite.
GaussianFit FitGaussian(const Eigen::MatrixXd& samples);

/// Squared Fréchet (2-Wasserstein) distance of two normal distributions:
/// |m1 - m2|^2 + tr(C1 + C2 - 2 (C1^1/2 C2 C1^1/2)^1/2) (Dowson & Landau 1982). It is the squared form, as
/// the field's "Fréchet inception distance" has it.
/// @throws std::invalid_argument when sizes differ; std::runtime_error when an eigen-decomposition fails.
double FrechetDistance(const GaussianFit& a, const GaussianFit& b);

}  // namespace morphograph
