#pragma once

#include <Eigen/Core>

#include "graph/gaussian_process.h"

namespace morphograph::internal {

/// Kernel of maximum marginal likelihood, see GaussianProcess::Fit.
GaussianProcessKernel SearchKernel(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                                   const GaussianProcessOptions& options);

}  // namespace morphograph::internal
