#include "graph/internal/kernel_search.h"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "graph/internal/kernel_matrix.h"

namespace morphograph {
namespace internal {
namespace {

// The terms of the likelihood at K = signal R(length) + linear G + noise I, with their derivatives by the logs of
// (signal, length, noise, linear).
struct LikelihoodTerms {
  double log_determinant = 0;  // ln|K|
  double quadratic = 0;        // tr(Y K^-1 Y^T)
  Eigen::Vector4d log_determinant_gradient = Eigen::Vector4d::Zero();
  Eigen::Vector4d quadratic_gradient = Eigen::Vector4d::Zero();
};

LikelihoodTerms Terms(const Eigen::MatrixXd& squared_distances, const Eigen::MatrixXd& products, const Eigen::MatrixXd& outputs,
                      const GaussianProcessKernel& kernel, bool with_gradient) {
  const Eigen::Index n = squared_distances.rows();
  const double scale = 1.0 / (kernel.length_scale * kernel.length_scale);
  const Eigen::MatrixXd rbf = kernel.signal_variance * (-0.5 * scale * squared_distances.array()).exp();
  Eigen::MatrixXd covariance = rbf;
  if (kernel.linear_variance > 0) covariance += kernel.linear_variance * products;
  covariance.diagonal().array() += kernel.noise_variance;
  const Eigen::LLT<Eigen::MatrixXd> llt = CholeskyWithJitter(covariance);
  const Eigen::MatrixXd alpha = llt.solve(outputs.transpose());

  LikelihoodTerms out;
  out.log_determinant = 2 * llt.matrixLLT().diagonal().array().log().sum();
  out.quadratic = (alpha.array() * outputs.transpose().array()).sum();
  if (!with_gradient) return out;
  // d ln|K| = tr(K^-1 dK); d tr(Y K^-1 Y^T) = -tr(alpha^T dK alpha). Both are sums over matching entries.
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(n, n));  // wanted whole, for the traces
  Eigen::MatrixXd outer(n, n);
  outer.noalias() = alpha * alpha.transpose();
  const auto both = [&](int index, const Eigen::MatrixXd& derivative) {
    out.log_determinant_gradient[index] = inverse.cwiseProduct(derivative).sum();
    out.quadratic_gradient[index] = -outer.cwiseProduct(derivative).sum();
  };
  both(0, rbf);
  both(1, rbf.cwiseProduct(squared_distances) * scale);
  out.log_determinant_gradient[2] = kernel.noise_variance * inverse.trace();
  out.quadratic_gradient[2] = -kernel.noise_variance * outer.trace();
  if (kernel.linear_variance > 0) both(3, kernel.linear_variance * products);
  return out;
}

// A log parameter held between bounds by the logistic function, so that the solver may move freely.
struct BoundedLog {
  double low = 0, high = 0;

  double At(double free, double* slope) const {
    const double s = 1 / (1 + std::exp(-free));
    *slope = (high - low) * s * (1 - s);
    return low + (high - low) * s;
  }
  double Free(double log_value) const {
    const double s = std::clamp((log_value - low) / (high - low), 0.01, 0.99);
    return std::log(s / (1 - s));
  }
};

// Minus the log marginal likelihood with the overall scale solved for: K = c A with A of signal variance 1, and
// c = tr(Y A^-1 Y^T) / (N E) at the maximum. What is left, up to constants: N E / 2 ln c + E / 2 ln|A|. By the envelope
// theorem its gradient is that with c held fixed.
class ConcentratedLikelihood final : public ceres::FirstOrderFunction {
 public:
  ConcentratedLikelihood(const Eigen::MatrixXd& inputs, Eigen::MatrixXd outputs, std::vector<BoundedLog> bounds)
      : squared_distances_(SquaredDistances(inputs, inputs)),
        products_(inputs.transpose() * inputs),
        outputs_(std::move(outputs)),
        bounds_(std::move(bounds)) {}

  int NumParameters() const override { return static_cast<int>(bounds_.size()); }

  /// Parameters: length scale, noise ratio and, if there are three, linear ratio.
  GaussianProcessKernel KernelAt(const double* parameters) const {
    double slope;
    GaussianProcessKernel kernel;
    kernel.signal_variance = 1;
    kernel.length_scale = std::exp(bounds_[0].At(parameters[0], &slope));
    kernel.noise_variance = std::exp(bounds_[1].At(parameters[1], &slope));
    kernel.linear_variance = bounds_.size() > 2 ? std::exp(bounds_[2].At(parameters[2], &slope)) : 0;
    return kernel;
  }

  double Scale(const LikelihoodTerms& terms) const {
    return std::max(terms.quadratic / static_cast<double>(outputs_.size()), std::numeric_limits<double>::min());
  }

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    try {
      const LikelihoodTerms terms =
          Terms(squared_distances_, products_, outputs_, KernelAt(parameters), gradient != nullptr);
      const double scale = Scale(terms);
      const auto outputs = static_cast<double>(outputs_.rows());
      const double per_value = 1.0 / static_cast<double>(outputs_.size());  // keeps the solver's tolerances meaningful
      *cost = 0.5 * std::log(scale) + 0.5 * outputs * terms.log_determinant * per_value;
      if (gradient) {
        for (std::size_t i = 0; i < bounds_.size(); ++i) {
          double slope;
          bounds_[i].At(parameters[i], &slope);
          const auto index = static_cast<Eigen::Index>(i + 1);  // in LikelihoodTerms: after the signal
          gradient[i] = slope * 0.5 * per_value *
                        (terms.quadratic_gradient[index] / scale + outputs * terms.log_determinant_gradient[index]);
        }
      }
      return std::isfinite(*cost);
    } catch (const std::runtime_error&) {
      return false;  // not positive definite: the solver takes a shorter step
    }
  }

  /// The kernel with its scale put back.
  GaussianProcessKernel ScaledKernel(const double* parameters) const {
    GaussianProcessKernel kernel = KernelAt(parameters);
    const double scale = Scale(Terms(squared_distances_, products_, outputs_, kernel, false));
    kernel.signal_variance *= scale;
    kernel.noise_variance *= scale;
    kernel.linear_variance *= scale;
    return kernel;
  }

 private:
  Eigen::MatrixXd squared_distances_, products_, outputs_;
  std::vector<BoundedLog> bounds_;
};

double MedianDistance(const Eigen::MatrixXd& inputs) {
  const Eigen::MatrixXd squared = SquaredDistances(inputs, inputs);
  std::vector<double> positive;
  for (Eigen::Index j = 0; j < squared.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i)
      if (squared(i, j) > 0) positive.push_back(squared(i, j));
  if (positive.empty()) return 1;  // one point, or equal ones: any scale does
  const auto middle = positive.begin() + static_cast<std::ptrdiff_t>(positive.size() / 2);
  std::nth_element(positive.begin(), middle, positive.end());
  return std::sqrt(*middle);
}

}  // namespace

GaussianProcessKernel SearchKernel(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                                   const GaussianProcessOptions& options) {
  if (options.search_points < 1 || options.starts < 1 || options.max_iterations < 1 ||
      !(options.min_noise_ratio > 0 && options.min_noise_ratio < 1e3))
    throw std::invalid_argument(
        "GaussianProcess: search_points, starts and max_iterations must be >= 1 and min_noise_ratio in (0, 1000)");
  // Every n-th pair, so that the whole capture has its say.
  const Eigen::Index all = inputs.cols(), count = std::min<Eigen::Index>(all, options.search_points);
  std::vector<Eigen::Index> chosen(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < count; ++i) chosen[i] = i * all / count;
  const Eigen::MatrixXd x = inputs(Eigen::all, chosen), y = outputs(Eigen::all, chosen);

  const double distance = MedianDistance(x);
  const double mean_square = std::max(x.colwise().squaredNorm().mean(), 1e-300);
  std::vector<BoundedLog> bounds = {{std::log(distance / 20), std::log(distance * 20)},
                                    {std::log(options.min_noise_ratio), std::log(1e4)}};
  if (options.linear) bounds.push_back({std::log(1e-6 / mean_square), std::log(1e4 / mean_square)});

  // The problem owns the function; it outlives every use of the pointer here.
  auto* const likelihood = new ConcentratedLikelihood(x, y, bounds);
  const ceres::GradientProblem problem(likelihood);
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::BFGS;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-7;  // of a cost per output value
  solver.logging_type = ceres::SILENT;

  constexpr std::array<double, 3> kStartScales = {1.0, 0.2, 5.0};  // of the median distance
  std::array<double, 3> best{};
  double best_cost = std::numeric_limits<double>::infinity();
  for (int start = 0; start < options.starts; ++start) {
    const double scale = kStartScales[static_cast<std::size_t>(start) % kStartScales.size()];
    std::array<double, 3> parameters{};
    parameters[0] = bounds[0].Free(std::log(distance * scale));
    parameters[1] = bounds[1].Free(std::log(start % 2 == 0 ? 0.1 : 1.0));
    if (options.linear) parameters[2] = bounds[2].Free(std::log(1.0 / mean_square));
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(solver, problem, parameters.data(), &summary);
    if (!summary.IsSolutionUsable() || !(summary.final_cost < best_cost)) continue;
    best_cost = summary.final_cost;
    best = parameters;
  }
  if (!std::isfinite(best_cost)) throw std::runtime_error("GaussianProcess: the search for a kernel failed from every start");
  GaussianProcessKernel kernel = likelihood->ScaledKernel(best.data());
  // Outputs that are all zero have no scale; a process that predicts zero needs some positive noise all the same.
  kernel.noise_variance = std::max(kernel.noise_variance, 1e-300);
  return kernel;
}

}  // namespace internal

double LogMarginalLikelihood(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const GaussianProcessKernel& kernel,
                             Eigen::Vector4d* gradient) {
  if (inputs.cols() != outputs.cols())
    throw std::invalid_argument("LogMarginalLikelihood: " + std::to_string(inputs.cols()) + " inputs but " +
                                std::to_string(outputs.cols()) + " outputs");
  const internal::LikelihoodTerms terms =
      internal::Terms(internal::SquaredDistances(inputs, inputs), inputs.transpose() * inputs, outputs, kernel, gradient != nullptr);
  const auto count = static_cast<double>(outputs.rows());
  if (gradient) *gradient = -0.5 * (terms.quadratic_gradient + count * terms.log_determinant_gradient);
  return -0.5 * (terms.quadratic + count * terms.log_determinant +
                 static_cast<double>(outputs.size()) * std::log(2 * std::numbers::pi));
}

}  // namespace morphograph
