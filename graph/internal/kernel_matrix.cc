#include "graph/internal/kernel_matrix.h"

#include <stdexcept>

namespace morphograph::internal {

Eigen::MatrixXd SquaredDistances(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd out = -2.0 * (a.transpose() * b);
  out.colwise() += a.colwise().squaredNorm().transpose();
  out.rowwise() += b.colwise().squaredNorm();
  return out.cwiseMax(0.0);
}

Eigen::MatrixXd KernelMatrix(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const double scale = -0.5 / (kernel.length_scale * kernel.length_scale);
  Eigen::MatrixXd out = kernel.signal_variance * (scale * SquaredDistances(a, b).array()).exp();
  if (kernel.linear_variance > 0) out.noalias() += kernel.linear_variance * (a.transpose() * b);
  return out;
}

Eigen::MatrixXd KernelMatrix(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& a) {
  return KernelMatrix(kernel, a, a);
}

Eigen::LLT<Eigen::MatrixXd> CholeskyWithJitter(const Eigen::MatrixXd& covariance) {
  Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  const double mean = covariance.diagonal().mean();
  for (double jitter = 1e-10; llt.info() != Eigen::Success && jitter < 2e-4; jitter *= 10) {
    Eigen::MatrixXd raised = covariance;
    raised.diagonal().array() += jitter * mean;
    llt.compute(raised);
  }
  if (llt.info() != Eigen::Success)
    throw std::runtime_error("GaussianProcess: the covariance is not positive definite; the inputs may be too large or not finite");
  return llt;
}

}  // namespace morphograph::internal
