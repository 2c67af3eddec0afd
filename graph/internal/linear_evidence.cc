#include "graph/internal/linear_evidence.h"

#include <Eigen/Eigenvalues>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <stdexcept>

namespace morphograph::internal {

GaussianProcessKernel SearchLinearKernel(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs) {
  // K = c (X^T X + r I). In the eigenvectors u_i of X^T X, with eigenvalues s_i, likelihood and the best c are sums over i.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(inputs.transpose() * inputs);
  if (solver.info() != Eigen::Success) throw std::runtime_error("SearchLinearKernel: eigen decomposition failed");
  const Eigen::ArrayXd values = solver.eigenvalues().cwiseMax(0.0);
  const Eigen::ArrayXd energy = (outputs * solver.eigenvectors()).colwise().squaredNorm();
  const double per_value = 1.0 / static_cast<double>(outputs.size());
  const auto scale = [&](double ratio) { return std::max((energy / (values + ratio)).sum() * per_value, 1e-12); };
  const auto cost = [&](double log_ratio) {
    const double ratio = std::exp(log_ratio);
    return std::log(scale(ratio)) + (values + ratio).log().sum() / static_cast<double>(values.size());
  };
  const double mean_square = std::max(inputs.colwise().squaredNorm().mean(), 1e-12);
  const double log_ratio =
      boost::math::tools::brent_find_minima(cost, std::log(1e-3 * mean_square), std::log(1e4 * mean_square), 20).first;
  GaussianProcessKernel kernel;
  kernel.signal_variance = 0;
  kernel.linear_variance = scale(std::exp(log_ratio));
  kernel.noise_variance = kernel.linear_variance * std::exp(log_ratio);
  return kernel;
}

}  // namespace morphograph::internal
