#include "graph/gaussian_process.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <string>

#include "graph/internal/kernel_search.h"
#include "graph/internal/kernel_matrix.h"

namespace morphograph {
namespace {

using internal::CholeskyWithJitter;
using internal::KernelMatrix;

void Check(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs) {
  const auto fail = [](const std::string& problem) { throw std::invalid_argument("GaussianProcess: " + problem); };
  if (inputs.cols() != outputs.cols())
    fail(std::to_string(inputs.cols()) + " inputs but " + std::to_string(outputs.cols()) + " outputs");
  if (inputs.cols() < 1) fail("no pairs given");
  if (inputs.rows() < 1 || outputs.rows() < 1) fail("inputs and outputs need at least one dimension");
  if (!inputs.allFinite() || !outputs.allFinite()) fail("pairs hold values that are not finite");
}

void Check(const GaussianProcessKernel& kernel) {
  if (!(kernel.signal_variance >= 0) || !(kernel.length_scale > 0) || !(kernel.linear_variance >= 0) ||
      !(kernel.noise_variance > 0) || !std::isfinite(kernel.length_scale))
    throw std::invalid_argument("GaussianProcess: needs length_scale > 0, noise_variance > 0, other variances >= 0");
}

// Farthest-first traversal from the input nearest to the mean: each next point is the one farthest from all before.
std::vector<Eigen::Index> FarthestFirst(const Eigen::MatrixXd& inputs, int count) {
  std::vector<Eigen::Index> chosen;
  Eigen::VectorXd nearest = (inputs.colwise() - inputs.rowwise().mean()).colwise().squaredNorm();
  Eigen::Index next = 0;
  nearest.minCoeff(&next);
  nearest.setConstant(std::numeric_limits<double>::infinity());
  while (static_cast<int>(chosen.size()) < count) {
    chosen.push_back(next);
    nearest = nearest.cwiseMin((inputs.colwise() - inputs.col(next)).colwise().squaredNorm().transpose());
    if (!(nearest.maxCoeff(&next) > 0)) break;  // all that is left are duplicates
  }
  return chosen;
}

double HalfLogTwoPi(Eigen::Index pairs, Eigen::Index outputs) {
  return 0.5 * static_cast<double>(pairs * outputs) * std::log(2 * std::numbers::pi);
}

GaussianProcess Exact(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs) {
  Eigen::MatrixXd covariance = KernelMatrix(kernel, inputs);
  covariance.diagonal().array() += kernel.noise_variance;
  const Eigen::LLT<Eigen::MatrixXd> llt = CholeskyWithJitter(covariance);
  Eigen::MatrixXd alpha = llt.solve(outputs.transpose());
  const double log_likelihood = -0.5 * (alpha.array() * outputs.transpose().array()).sum() -
                                static_cast<double>(outputs.rows()) * llt.matrixLLT().diagonal().array().log().sum() -
                                HalfLogTwoPi(inputs.cols(), outputs.rows());
  return GaussianProcess(kernel, inputs, std::move(alpha), log_likelihood);
}

// Fully independent training conditional: given the inducing values, outputs are independent, each with the variance that
// the inducing points leave unexplained. With L L^T = K_mm, V = L^-1 K_mn, Lambda that variance plus noise and
// B = I + V Lambda^-1 V^T: mean = k_m^T L^-T B^-1 V Lambda^-1 Y^T. Costs O(N M^2).
GaussianProcess Fitc(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                     int inducing_points) {
  const std::vector<Eigen::Index> chosen = FarthestFirst(inputs, inducing_points);
  const Eigen::MatrixXd inducing = inputs(Eigen::all, chosen);
  const auto m = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd covariance = KernelMatrix(kernel, inducing);
  // K_mm has no noise of its own; this much keeps it definite and moves nothing that matters.
  covariance.diagonal().array() += 1e-8 * covariance.diagonal().maxCoeff();
  const Eigen::LLT<Eigen::MatrixXd> llt = CholeskyWithJitter(covariance);
  Eigen::MatrixXd v = KernelMatrix(kernel, inducing, inputs);
  llt.matrixL().solveInPlace(v);
  const Eigen::VectorXd prior_variance =
      kernel.signal_variance + kernel.linear_variance * inputs.colwise().squaredNorm().transpose().array();
  const Eigen::VectorXd lambda =
      (prior_variance - v.colwise().squaredNorm().transpose()).cwiseMax(0.0).array() + kernel.noise_variance;
  const Eigen::MatrixXd scaled = v * lambda.cwiseInverse().asDiagonal();
  Eigen::MatrixXd b = Eigen::MatrixXd::Identity(m, m);
  b.noalias() += scaled * v.transpose();
  const Eigen::LLT<Eigen::MatrixXd> llt_b = CholeskyWithJitter(b);
  const Eigen::MatrixXd projected = scaled * outputs.transpose();
  Eigen::MatrixXd alpha = llt_b.solve(projected);
  const double quadratic = (outputs.array().square().colwise().sum().transpose() / lambda.array()).sum() -
                           (projected.array() * alpha.array()).sum();
  const double half_log_determinant =
      0.5 * lambda.array().log().sum() + llt_b.matrixLLT().diagonal().array().log().sum();
  const double log_likelihood = -0.5 * quadratic - static_cast<double>(outputs.rows()) * half_log_determinant -
                                HalfLogTwoPi(inputs.cols(), outputs.rows());
  llt.matrixU().solveInPlace(alpha);
  return GaussianProcess(kernel, inducing, std::move(alpha), log_likelihood);
}

}  // namespace

// The Cholesky factor of K + noise, made when a variance is first asked for.
struct GaussianProcess::LazyFactor {
  std::once_flag once;
  Eigen::LLT<Eigen::MatrixXd> llt;
};

GaussianProcess::GaussianProcess(const GaussianProcessKernel& kernel, Eigen::MatrixXd inputs, Eigen::MatrixXd alpha,
                                 double log_marginal_likelihood)
    : kernel_(kernel),
      inputs_(std::move(inputs)),
      alpha_(std::move(alpha)),
      log_marginal_likelihood_(log_marginal_likelihood),
      factor_(std::make_shared<LazyFactor>()) {
  Check(kernel_);
  Check(inputs_, alpha_.transpose());
  squared_norms_ = inputs_.colwise().squaredNorm().transpose();
}

GaussianProcess GaussianProcess::Fit(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                                     const GaussianProcessOptions& options) {
  Check(inputs, outputs);
  return Condition(internal::SearchKernel(inputs, outputs, options), inputs, outputs, options);
}

GaussianProcess GaussianProcess::Condition(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& inputs,
                                           const Eigen::MatrixXd& outputs, const GaussianProcessOptions& options) {
  Check(inputs, outputs);
  Check(kernel);
  if (inputs.cols() <= options.max_exact_pairs) return Exact(kernel, inputs, outputs);
  if (options.inducing_points < 1)
    throw std::invalid_argument("GaussianProcess: inducing_points is " + std::to_string(options.inducing_points) + "; must be >= 1");
  return Fitc(kernel, inputs, outputs, options.inducing_points);
}

Eigen::VectorXd GaussianProcess::KernelVector(const Eigen::VectorXd& input) const {
  if (input.size() != inputs_.rows())
    throw std::invalid_argument("GaussianProcess: an input has " + std::to_string(input.size()) + " entries; expected " +
                                std::to_string(inputs_.rows()));
  const Eigen::VectorXd products = inputs_.transpose() * input;
  const double scale = -0.5 / (kernel_.length_scale * kernel_.length_scale);
  Eigen::VectorXd out =
      kernel_.signal_variance *
      (scale * (squared_norms_.array() - 2.0 * products.array() + input.squaredNorm()).max(0.0)).exp();
  if (kernel_.linear_variance > 0) out += kernel_.linear_variance * products;
  return out;
}

Eigen::VectorXd GaussianProcess::PredictMean(const Eigen::VectorXd& input) const {
  return alpha_.transpose() * KernelVector(input);
}

Eigen::MatrixXd GaussianProcess::MeanJacobian(const Eigen::VectorXd& input) const {
  const Eigen::VectorXd kernel = KernelVector(input);
  Eigen::VectorXd rbf = kernel;
  if (kernel_.linear_variance > 0) rbf -= kernel_.linear_variance * (inputs_.transpose() * input);
  const double scale = 1 / (kernel_.length_scale * kernel_.length_scale);
  Eigen::MatrixXd gradients = (inputs_.colwise() - input) * (scale * rbf).asDiagonal();  // of each kernel value, (D x N)
  if (kernel_.linear_variance > 0) gradients += kernel_.linear_variance * inputs_;
  return alpha_.transpose() * gradients.transpose();
}

GaussianPrediction GaussianProcess::Predict(const Eigen::VectorXd& input) const {
  Eigen::VectorXd k = KernelVector(input);
  std::call_once(factor_->once, [this] {
    Eigen::MatrixXd covariance = KernelMatrix(kernel_, inputs_);
    covariance.diagonal().array() += kernel_.noise_variance;
    factor_->llt = CholeskyWithJitter(covariance);
  });
  GaussianPrediction out;
  out.mean.noalias() = alpha_.transpose() * k;
  factor_->llt.matrixL().solveInPlace(k);
  const double prior = kernel_.signal_variance + kernel_.linear_variance * input.squaredNorm();
  out.variance = std::max(0.0, prior - k.squaredNorm());  // rounding may leave a tiny negative number on a training point
  return out;
}

}  // namespace morphograph
