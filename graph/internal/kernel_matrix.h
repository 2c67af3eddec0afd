#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "graph/gaussian_process.h"

namespace morphograph::internal {

/// Squared distances between the columns of `a` and `b`, (columns of a x columns of b), >= 0.
Eigen::MatrixXd SquaredDistances(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Kernel without noise between the columns of `a` and `b`, and of `a` with itself.
Eigen::MatrixXd KernelMatrix(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd KernelMatrix(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& a);

/// Cholesky factorisation. Where rounding has made the matrix indefinite, 1e-10 of its mean diagonal is added to the
/// diagonal, then ten times more, up to 1e-4.
/// @throws std::runtime_error when that is not enough.
Eigen::LLT<Eigen::MatrixXd> CholeskyWithJitter(const Eigen::MatrixXd& covariance);

}  // namespace morphograph::internal
