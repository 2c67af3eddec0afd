#pragma once

#include <Eigen/Core>
#include <memory>

namespace morphograph {

/// k(x, y) = signal_variance exp(-|x - y|^2 / (2 length_scale^2)) + linear_variance x.y, and white noise on the outputs.
struct GaussianProcessKernel {
  double signal_variance = 1;
  double length_scale = 1;
  double linear_variance = 0;  // 0: no linear part
  double noise_variance = 0.1;
};

struct GaussianProcessOptions {
  bool linear = false;         // search for linear_variance too
  int search_points = 200;     // pairs used to find the kernel, evenly spread over all; the fit itself uses every pair
  int starts = 2;              // of the search, at different length scales
  int max_iterations = 40;     // of each
  double min_noise_ratio = 1e-6;  // noise variance over signal variance; keeps duplicates harmless
  int max_exact_pairs = 2000;  // beyond this, inducing points
  int inducing_points = 400;
};

struct GaussianPrediction {
  Eigen::VectorXd mean;  // (E)
  double variance = 0;   // of the function, the same for each output; add the kernel's noise_variance for an observation
};

/// Log marginal likelihood of outputs given inputs, summed over the outputs, which share kernel and factorisation:
/// -1/2 tr(Y K^-1 Y^T) - E/2 ln|K| - N E / 2 ln(2 pi), K = k(X, X) + noise I (Du Eq. 3.46).
///
/// @param inputs  (D x N), @param outputs  (E x N).
/// @param gradient  if given, by the logs of (signal_variance, length_scale, noise_variance, linear_variance), analytic.
double LogMarginalLikelihood(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const GaussianProcessKernel& kernel,
                             Eigen::Vector4d* gradient = nullptr);

/// Gaussian-process regression with several outputs that share one kernel and one Cholesky factorisation (Du 3.5.1).
///
/// The prior mean is 0: take means out first. Immutable after construction and safe to share between threads.
class GaussianProcess {
 public:
  /// Fits kernel and process. The kernel maximises the marginal likelihood (of at most `search_points` pairs), within a
  /// length scale of 1/20 to 20 times the median distance of the inputs and a noise ratio of min_noise_ratio to 1e4; the
  /// overall scale is solved for in closed form. Deterministic.
  ///
  /// Beyond max_exact_pairs the process rests on inducing points, chosen farthest-first, by the FITC approximation
  /// (Snelson & Ghahramani 2006).
  /// @throws std::invalid_argument when sizes do not fit, there are no pairs or no dimensions, or values are not finite.
  static GaussianProcess Fit(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                             const GaussianProcessOptions& options = {});

  /// The same for a given kernel, without a search.
  static GaussianProcess Condition(const GaussianProcessKernel& kernel, const Eigen::MatrixXd& inputs,
                                   const Eigen::MatrixXd& outputs, const GaussianProcessOptions& options = {});

  /// From stored parts. Cheap: the factor that variances need is computed by the first Predict, once.
  /// @param inputs  (D x N) training inputs or inducing points. @param alpha  (N x E): mean(x) = alpha^T k(x).
  GaussianProcess(const GaussianProcessKernel& kernel, Eigen::MatrixXd inputs, Eigen::MatrixXd alpha,
                  double log_marginal_likelihood);

  const GaussianProcessKernel& kernel() const { return kernel_; }
  const Eigen::MatrixXd& inputs() const { return inputs_; }
  const Eigen::MatrixXd& alpha() const { return alpha_; }
  /// Of all pairs, under the fitted kernel (FITC's where inducing points are used).
  double log_marginal_likelihood() const { return log_marginal_likelihood_; }
  int input_dimension() const { return static_cast<int>(inputs_.rows()); }
  int output_dimension() const { return static_cast<int>(alpha_.cols()); }
  int points() const { return static_cast<int>(inputs_.cols()); }

  /// Mean and variance (Eq. 3.49-3.50): alpha^T k and k(x, x) - v.v with L v = k.
  ///
  /// With inducing points the variance is that of a process which has seen these points only: an upper bound that
  /// needs nothing but the stored parts.
  /// @throws std::invalid_argument when the size differs; so does PredictMean.
  GaussianPrediction Predict(const Eigen::VectorXd& input) const;
  /// The mean alone (E), several times faster.
  Eigen::VectorXd PredictMean(const Eigen::VectorXd& input) const;
  /// d mean / d input, (E x D), analytic.
  Eigen::MatrixXd MeanJacobian(const Eigen::VectorXd& input) const;

 private:
  struct LazyFactor;

  Eigen::VectorXd KernelVector(const Eigen::VectorXd& input) const;

  GaussianProcessKernel kernel_;
  Eigen::MatrixXd inputs_;          // (D x N)
  Eigen::VectorXd squared_norms_;   // (N)
  Eigen::MatrixXd alpha_;           // (N x E)
  double log_marginal_likelihood_ = 0;
  std::shared_ptr<LazyFactor> factor_;  // shared by copies
};

}  // namespace morphograph
