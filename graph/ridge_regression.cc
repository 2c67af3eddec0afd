#include "graph/ridge_regression.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <map>
#include <stdexcept>

#include "graph/internal/linear_evidence.h"

namespace morphograph {

RidgeRegression FitRidge(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const std::vector<int>& groups) {
  if (inputs.cols() != outputs.cols() || groups.size() != static_cast<size_t>(inputs.cols())) {
    throw std::invalid_argument("FitRidge: needs an output and a group for each input");
  }
  std::map<int, std::vector<Eigen::Index>> members;
  for (size_t i = 0; i < groups.size(); ++i) members[groups[i]].push_back(static_cast<Eigen::Index>(i));
  if (members.size() < 2) throw std::invalid_argument("FitRidge: needs two groups at least");

  const GaussianProcessKernel kernel = internal::SearchLinearKernel(inputs, outputs);
  const Eigen::Index count = inputs.cols();
  const Eigen::MatrixXd gram = kernel.linear_variance * inputs.transpose() * inputs;
  Eigen::MatrixXd covariance = gram;
  covariance.diagonal().array() += kernel.noise_variance;
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) throw std::runtime_error("FitRidge: the ridge is too small for these inputs");
  RidgeRegression ridge;
  ridge.map = kernel.linear_variance * (inputs * llt.solve(outputs.transpose())).transpose();

  // With H the hat matrix, a group left out is missed by (I - H_GG)^-1 times its residuals of the fit.
  const Eigen::MatrixXd hat = llt.solve(gram);
  const Eigen::MatrixXd residuals = outputs - ridge.map * inputs;
  double squares = 0;
  for (const auto& [group, of_group] : members) {
    const Eigen::Index size = static_cast<Eigen::Index>(of_group.size());
    const Eigen::MatrixXd left_over = Eigen::MatrixXd::Identity(size, size) - hat(of_group, of_group);
    const Eigen::MatrixXd of_these = residuals(Eigen::all, of_group).transpose();
    squares += left_over.partialPivLu().solve(of_these).squaredNorm();
  }
  ridge.noise_variance = squares / static_cast<double>(count * outputs.rows());
  return ridge;
}

}  // namespace morphograph
