#include "graph/transition_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "primitives/whitening.h"

namespace morphograph {
namespace {

struct Whitened {
  Eigen::MatrixXd values;      // (dims x pairs)
  std::vector<int> component;  // per pair
};

Whitened Whiten(const Eigen::MatrixXd& latents, const GaussianMixture& mixture) {
  Whitened result{Eigen::MatrixXd(latents.rows(), latents.cols()), {}};
  for (int i = 0; i < latents.cols(); ++i) {
    const int c = mixture.MostLikely(latents.col(i));
    result.values.col(i) = Whiten(mixture.Component(c), latents.col(i));
    result.component.push_back(c);
  }
  return result;
}

// Symmetric square root, or its inverse, with eigenvalues kept above `floor`.
Eigen::MatrixXd SymmetricPower(const Eigen::MatrixXd& matrix, double exponent, double floor) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success) throw std::runtime_error("FitTransition: eigen decomposition failed");
  const Eigen::VectorXd powers = solver.eigenvalues().cwiseMax(floor).array().pow(exponent);
  return solver.eigenvectors() * powers.asDiagonal() * solver.eigenvectors().transpose();
}

Eigen::MatrixXd RidgeMap(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& targets, const TransitionFitOptions& options) {
  const double n = static_cast<double>(inputs.cols());
  Eigen::MatrixXd gram = inputs * inputs.transpose() / n;
  gram.diagonal().array() += options.ridge;
  const Eigen::LLT<Eigen::MatrixXd> llt(gram);
  if (llt.info() != Eigen::Success) throw std::runtime_error("FitTransition: ridge system is not positive definite");
  const Eigen::MatrixXd cross = inputs * targets.transpose() / n;
  const Eigen::MatrixXd map = llt.solve(cross).transpose();
  // A gain of one or more would let walks drift off for ever.
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(map, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd gains = svd.singularValues().cwiseMin(options.largest_gain);
  return svd.matrixU() * gains.asDiagonal() * svd.matrixV().transpose();
}

Eigen::MatrixXd ComponentChances(const Whitened& source, const Whitened& target, const GaussianMixture& from,
                                 const GaussianMixture& to, double prior) {
  Eigen::MatrixXd chances(from.size(), to.size());
  for (int c = 0; c < to.size(); ++c) chances.col(c).setConstant(prior * std::exp(to.Component(c).log_weight));
  for (size_t i = 0; i < source.component.size(); ++i) chances(source.component[i], target.component[i]) += 1;
  for (int c = 0; c < from.size(); ++c) chances.row(c) /= chances.row(c).sum();
  return chances;
}

// What the process would miss each pair by, had it not seen it: alpha_i / (K^-1)_ii (Rasmussen & Williams 2006, Eq. 5.12).
// Residuals of the fit itself would shrink as the process follows its data.
Eigen::MatrixXd LeaveOneOutResiduals(const GaussianProcess& process, const Eigen::MatrixXd& inputs,
                                     const Eigen::MatrixXd& targets) {
  const Eigen::Index n = targets.cols();
  if (process.points() != n) {  // inducing points: few against the pairs, so the fit follows single ones little
    Eigen::MatrixXd residuals = targets;
    for (Eigen::Index i = 0; i < n; ++i) residuals.col(i) -= process.PredictMean(inputs.col(i));
    return residuals;
  }
  const GaussianProcessKernel& kernel = process.kernel();
  Eigen::MatrixXd gram(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double squared = (process.inputs().col(i) - process.inputs().col(j)).squaredNorm();
      gram(i, j) = gram(j, i) = kernel.signal_variance * std::exp(-0.5 * squared / (kernel.length_scale * kernel.length_scale));
    }
    gram(i, i) += kernel.noise_variance;
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(gram);
  if (llt.info() != Eigen::Success) throw std::runtime_error("FitTransition: kernel matrix is not positive definite");
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(n, n));
  return (inverse * targets.transpose()).transpose() * inverse.diagonal().cwiseInverse().asDiagonal();
}

// Log density of the columns under isotropic noise of their own mean square: what a process has to beat.
double WhiteNoiseEvidence(const Eigen::MatrixXd& values) {
  const double variance = std::max(values.squaredNorm() / values.size(), 1e-9);  // pairs may be met exactly
  return -0.5 * values.size() * (std::log(2 * M_PI * variance) + 1);
}

}  // namespace

TransitionModel FitTransition(const TransitionPairs& pairs, const GaussianMixture& source, const GaussianMixture& target,
                              const TransitionFitOptions& options) {
  if (pairs.previous.cols() == 0 || pairs.previous.cols() != pairs.next.cols()) {
    throw std::invalid_argument("FitTransition: needs as many next latents as previous ones, and at least one pair");
  }
  if (pairs.previous.rows() != source.dimension() || pairs.next.rows() != target.dimension()) {
    throw std::invalid_argument("FitTransition: latents do not fit the mixtures");
  }
  const Whitened from = Whiten(pairs.previous, source);
  const Whitened to = Whiten(pairs.next, target);
  const int count = static_cast<int>(pairs.previous.cols());

  TransitionModel model;
  model.pairs = count;
  model.component_chances = ComponentChances(from, to, source, target, options.chance_prior);
  model.residual_component = to.component;

  const Eigen::MatrixXd linear = RidgeMap(from.values, to.values, options);
  const Eigen::MatrixXd left_over = to.values - linear * from.values;
  model.linear = linear.cast<float>();
  model.log_marginal_likelihood = WhiteNoiseEvidence(left_over);
  model.noise_variance = left_over.squaredNorm() / left_over.size();

  Eigen::MatrixXd residuals = left_over;
  if (count >= options.min_pairs_for_process) {
    GaussianProcess process = GaussianProcess::Fit(from.values, left_over);
    model.length_scale = process.kernel().length_scale;
    model.signal_variance = process.kernel().signal_variance;
    // The process has two parameters more than white noise. Pairs are seldom near each other in fifty dimensions, and a process
    // that only remembers its few near ones would cost time and give nothing.
    const double worth = process.log_marginal_likelihood() - model.log_marginal_likelihood;
    if (worth > options.process_gain * static_cast<double>(left_over.size())) {
      model.log_marginal_likelihood = process.log_marginal_likelihood();
      model.noise_variance = process.kernel().noise_variance;
      residuals = LeaveOneOutResiduals(process, from.values, left_over);
      model.process = std::move(process);
    }
  }

  // Cov(A w + f(w)) + noise = I keeps the marginal. Shrinking the sample covariances towards their diagonal steadies small samples.
  const Eigen::MatrixXd means = to.values - residuals;
  const auto shrunk_covariance = [count](const Eigen::MatrixXd& values) {
    Eigen::MatrixXd covariance = values * values.transpose() / count;
    const double dims = static_cast<double>(values.rows());
    const double shrink = dims / (dims + count);
    const Eigen::VectorXd diagonal = covariance.diagonal();
    covariance *= 1 - shrink;
    covariance.diagonal() += shrink * diagonal;
    return covariance;
  };
  const Eigen::MatrixXd explained = shrunk_covariance(means);
  const Eigen::MatrixXd wanted =
      SymmetricPower(Eigen::MatrixXd::Identity(explained.rows(), explained.cols()) - explained, 1.0, options.smallest_noise);
  const Eigen::MatrixXd recolour =
      SymmetricPower(wanted, 0.5, options.smallest_noise) * SymmetricPower(shrunk_covariance(residuals), -0.5, 1e-6);
  model.residuals = (recolour * residuals).cast<float>();
  const Eigen::LLT<Eigen::MatrixXd> llt(wanted);
  if (llt.info() != Eigen::Success) throw std::runtime_error("FitTransition: noise covariance is not positive definite");
  model.noise_cholesky = llt.matrixL();
  return model;
}

}  // namespace morphograph
