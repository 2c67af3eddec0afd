#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

/// Linear regression with a ridge, y = M x + e: what a Gaussian process has to beat. No intercept, so take means out first.
struct RidgeRegression {
  Eigen::MatrixXd map;        // M, (E x D)
  double noise_variance = 0;  // of each output, the same everywhere: mean squared residual of groups left out

  Eigen::VectorXd Mean(const Eigen::VectorXd& input) const { return map * input; }
};

/// Every output has the ridge of its maximum marginal likelihood (internal/linear_map.h).
/// @param inputs  (D x N), @param outputs  (E x N). @param groups  per column; the columns of a group are never used to judge each other.
/// @throws std::invalid_argument when sizes do not fit or there are fewer than two groups.
RidgeRegression FitRidge(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const std::vector<int>& groups);

}  // namespace morphograph
