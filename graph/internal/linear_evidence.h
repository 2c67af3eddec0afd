#pragma once

#include <Eigen/Core>

#include "graph/gaussian_process.h"

namespace morphograph::internal {

/// The kernel linear_variance x.y with white noise, no RBF part, of maximum marginal likelihood: ridge regression whose ridge the
/// data choose. Exact but for a search over one number, the ratio of noise to linear variance (1e-3 to 1e4 mean squared inputs).
GaussianProcessKernel SearchLinearKernel(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs);

}  // namespace morphograph::internal
