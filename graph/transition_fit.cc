#include "graph/transition_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>

#include "graph/internal/kernel_matrix.h"
#include "graph/internal/kernel_search.h"
#include "graph/internal/linear_map.h"
#include "primitives/matrix_factors.h"
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

// What the shared motion says of the next step (E x D), averaged over the pairs' mixture components. How exactly the two ends agree is not
// known beforehand: recorded poses are reduced, and clocks differ. The noise is the one by which the pairs are predicted best.
Eigen::MatrixXd MapOfSharedMargin(const SharedMargin& margin, const TransitionPairs& pairs, const Whitened& from, const Whitened& to) {
  std::map<std::pair<int, int>, double> shares;  // of the pairs, by components
  for (size_t i = 0; i < from.component.size(); ++i) {
    shares[{from.component[i], to.component[i]}] += 1.0 / static_cast<double>(from.component.size());
  }
  const auto within = [](const std::vector<Eigen::MatrixXd>& jacobians, const PairManner& manner) {
    std::vector<Eigen::MatrixXd> scaled = jacobians;
    if (manner.within_scale.size() == 0) return scaled;
    for (Eigen::MatrixXd& jacobian : scaled) jacobian *= manner.within_scale.asDiagonal();
    return scaled;
  };
  const std::vector<Eigen::MatrixXd> ends = within(margin.end, pairs.previous_manner), starts = within(margin.start, pairs.next_manner);
  std::vector<std::pair<double, SharedMarginMap>> maps;  // by shares
  for (const auto& [components, share] : shares) {
    maps.emplace_back(share, SharedMarginMap(ends[static_cast<size_t>(components.first)], starts[static_cast<size_t>(components.second)]));
  }
  const double scale = starts.front().squaredNorm() / static_cast<double>(starts.front().cols());
  Eigen::MatrixXd best = Eigen::MatrixXd::Zero(to.values.rows(), from.values.rows());
  double least = to.values.squaredNorm();
  for (double log_noise = -4; log_noise <= 1; log_noise += 0.25) {
    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(best.rows(), best.cols());
    for (const auto& [share, of_components] : maps) map += share * of_components.WithNoise(scale * std::pow(10, log_noise));
    const double missed = (to.values - map * from.values).squaredNorm();
    if (missed < least) least = missed, best = std::move(map);
  }
  return best;
}

// What changes from step to step.
void TakeOut(const PairManner& manner, Whitened* whitened) {
  if (manner.within_scale.size() == 0) return;
  whitened->values = manner.within_scale.cwiseInverse().asDiagonal() * (whitened->values - manner.manner);
}

// Symmetric square root, or its inverse, with eigenvalues kept above `floor`.
Eigen::MatrixXd SymmetricPower(const Eigen::MatrixXd& matrix, double exponent, double floor) {
  const SymmetricFactors factors = FactorSymmetric(matrix);
  const Eigen::VectorXd powers = factors.values.cwiseMax(floor).array().pow(exponent);
  return factors.vectors * powers.asDiagonal() * factors.vectors.transpose();
}

// A gain of one or more would let walks drift off for ever.
Eigen::MatrixXd WithGainsUpTo(double largest, const Eigen::MatrixXd& map) {
  const SingularFactors factors = FactorSingular(map);
  const Eigen::VectorXd gains = factors.values.head(factors.u.cols()).cwiseMin(largest);
  return factors.u * gains.asDiagonal() * factors.v.transpose();
}

Eigen::MatrixXd ComponentChances(const Whitened& source, const Whitened& target, const GaussianMixture& from,
                                 const GaussianMixture& to, double prior) {
  Eigen::MatrixXd chances(from.size(), to.size());
  for (int c = 0; c < to.size(); ++c) chances.col(c).setConstant(prior * std::exp(to.Component(c).log_weight));
  for (size_t i = 0; i < source.component.size(); ++i) chances(source.component[i], target.component[i]) += 1;
  const Eigen::RowVectorXd of_all = chances.colwise().sum();
  for (int c = 0; c < from.size(); ++c) {
    if (!(chances.row(c).sum() > 0)) chances.row(c) = of_all;  // without a prior: a component that no pair left
    chances.row(c) /= chances.row(c).sum();
  }
  return chances;
}

// What the process would miss each pair by, had it seen no pair of the same clip: with K^-1 the inverse of kernel and noise and G
// the pairs of a clip, ((K^-1)_GG)^-1 (K^-1 Y^T)_G (Rasmussen & Williams 2006, Eq. 5.12, for blocks). Residuals of the fit itself
// would shrink as the process follows its data.
Eigen::MatrixXd UnseenResiduals(const GaussianProcess& process, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& targets,
                                const std::vector<int>& clips) {
  const Eigen::Index n = targets.cols();
  Eigen::MatrixXd residuals(targets.rows(), n);
  if (process.points() != n) {  // inducing points: few against the pairs, so the fit follows single ones little
    for (Eigen::Index i = 0; i < n; ++i) residuals.col(i) = targets.col(i) - process.PredictMean(inputs.col(i));
    return residuals;
  }
  Eigen::MatrixXd covariance = internal::KernelMatrix(process.kernel(), inputs);
  covariance.diagonal().array() += process.kernel().noise_variance;
  const Eigen::MatrixXd inverse = internal::CholeskyWithJitter(covariance).solve(Eigen::MatrixXd::Identity(n, n));
  std::map<int, std::vector<Eigen::Index>> members;
  for (Eigen::Index i = 0; i < n; ++i) members[clips.empty() ? static_cast<int>(i) : clips[static_cast<size_t>(i)]].push_back(i);
  for (const auto& [clip, of_clip] : members) {
    const Eigen::MatrixXd block = inverse(of_clip, of_clip);
    const Eigen::MatrixXd alpha = process.alpha()(of_clip, Eigen::all);
    residuals(Eigen::all, of_clip) = internal::CholeskyWithJitter(block).solve(alpha).transpose();
  }
  return residuals;
}

// The pairs that a kernel is chosen by: captured ones, as copies of one step are no independent evidence of anything.
std::vector<Eigen::Index> CapturedPairs(const TransitionPairs& pairs) {
  std::vector<Eigen::Index> captured, all;
  for (Eigen::Index i = 0; i < pairs.next.cols(); ++i) {
    all.push_back(i);
    if (pairs.made.empty() || !pairs.made[static_cast<size_t>(i)]) captured.push_back(i);
  }
  return captured.size() >= 2 ? captured : all;
}

// How much each whitened value of the likeliest component moves a step, against the one that moves it most.
Eigen::VectorXd InputScales(const GaussianMixture& mixture) {
  int likeliest = 0;
  for (int c = 1; c < mixture.size(); ++c) {
    if (mixture.Component(c).log_weight > mixture.Component(likeliest).log_weight) likeliest = c;
  }
  const Eigen::VectorXd norms = mixture.Component(likeliest).cholesky.colwise().norm();
  return norms / norms.maxCoeff();
}

// Mean and covariance of A w + f(w) over w ~ N(0, I).
struct Explained {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

Explained ExplainedBy(const Eigen::MatrixXd& linear, const std::optional<GaussianProcess>& process) {
  constexpr int kDraws = 4000;
  Explained explained{Eigen::VectorXd::Zero(linear.rows()), linear * linear.transpose()};
  if (!process) return explained;
  std::mt19937_64 rng(1);
  boost::random::normal_distribution<double> normal;
  Eigen::MatrixXd means(linear.rows(), kDraws);
  Eigen::VectorXd w(linear.cols());
  for (int i = 0; i < kDraws; i += 2) {  // w and -w: the linear part's mean is then exact
    for (double& value : w) value = normal(rng);
    means.col(i) = linear * w + process->PredictMean(w);
    means.col(i + 1) = -linear * w + process->PredictMean(-w);
  }
  explained.mean = means.rowwise().mean();
  means.colwise() -= explained.mean;
  explained.covariance = means * means.transpose() / kDraws;
  return explained;
}

// Second moments of the columns, shrunk towards their diagonal, which steadies small samples.
Eigen::MatrixXd ShrunkMoments(const Eigen::MatrixXd& values) {
  const double count = static_cast<double>(values.cols()), dims = static_cast<double>(values.rows());
  Eigen::MatrixXd moments = values * values.transpose() / count;
  const double shrink = dims / (dims + count);
  const Eigen::VectorXd diagonal = moments.diagonal();
  moments *= 1 - shrink;
  moments.diagonal() += shrink * diagonal;
  return moments;
}

// Takes the mean of each component's residuals out: what is left of it would move a component's mean from step to step.
void Centre(const std::vector<int>& component, Eigen::MatrixXd* residuals) {
  std::map<int, std::vector<Eigen::Index>> members;
  for (size_t i = 0; i < component.size(); ++i) members[component[i]].push_back(static_cast<Eigen::Index>(i));
  for (const auto& [c, of_component] : members) {
    if (of_component.size() < 2) continue;
    const Eigen::VectorXd mean = (*residuals)(Eigen::all, of_component).rowwise().mean();
    for (const Eigen::Index i : of_component) residuals->col(i) -= mean;
  }
}

// Residuals given the second moments `wanted`: their directions up to what shrinking leaves, their sum exactly.
Eigen::MatrixXd Recoloured(const Eigen::MatrixXd& residuals, const Eigen::MatrixXd& wanted, double smallest) {
  const Eigen::MatrixXd recoloured =
      SymmetricPower(wanted, 0.5, smallest) * SymmetricPower(ShrunkMoments(residuals), -0.5, 1e-6) * residuals;
  const double energy = recoloured.squaredNorm() / static_cast<double>(recoloured.cols());
  return energy > 0 ? Eigen::MatrixXd(std::sqrt(wanted.trace() / energy) * recoloured) : recoloured;
}

struct LinearPart {
  internal::LinearRidges ridges;
  internal::LinearMap fitted;
};

// The next step comes from the target's mixture, whatever the one before was.
TransitionModel IndependentTransition(int pairs, const GaussianMixture& source, const GaussianMixture& target) {
  TransitionModel model;
  model.pairs = pairs;
  model.component_chances.resize(source.size(), target.size());
  for (int c = 0; c < target.size(); ++c) model.component_chances.col(c).setConstant(std::exp(target.Component(c).log_weight));
  model.linear = Eigen::MatrixXf::Zero(target.dimension(), source.dimension());
  model.residuals.resize(target.dimension(), 0);  // drawn from the normal distribution then
  model.noise_cholesky = Eigen::MatrixXd::Identity(target.dimension(), target.dimension());
  model.noise_variance = model.unseen_error = 1;
  return model;
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
  const auto fits = [&](size_t size) { return size == 0 || size == static_cast<size_t>(pairs.next.cols()); };
  if (!fits(pairs.clip.size()) || !fits(pairs.made.size())) {
    throw std::invalid_argument("FitTransition: needs the clip of every pair, or of none");
  }
  using Form = TrainingVariant::Transition;
  if (options.form == Form::kNone) return IndependentTransition(static_cast<int>(pairs.next.cols()), source, target);
  const bool stationary = options.form == Form::kStationary;
  const bool keep_marginal = options.keep_marginal && stationary;
  Whitened from = Whiten(pairs.previous, source);
  Whitened to = Whiten(pairs.next, target);
  TakeOut(pairs.previous_manner, &from);
  TakeOut(pairs.next_manner, &to);
  const int count = static_cast<int>(pairs.previous.cols());

  TransitionModel model;
  model.pairs = count;
  // Where residuals stand for themselves, only components that have some may follow.
  model.component_chances = ComponentChances(from, to, source, target, keep_marginal ? options.chance_prior : 0);
  model.residual_component = to.component;

  const std::vector<Eigen::Index> captured = CapturedPairs(pairs);
  const Eigen::MatrixXd captured_from = from.values(Eigen::all, captured);
  Eigen::MatrixXd linear = Eigen::MatrixXd::Zero(to.values.rows(), from.values.rows());
  Eigen::MatrixXd residuals = to.values;
  if (stationary) {
    // Pairs teach what `told` leaves.
    const auto fit = [&](const Eigen::MatrixXd& told) {
      const Eigen::MatrixXd left = to.values - told * from.values;
      LinearPart part{internal::SearchLinearRidges(captured_from, left(Eigen::all, captured), InputScales(source)), {}};
      part.fitted = internal::FitLinearMap(part.ridges, from.values, left, pairs.clip);
      part.fitted.map += told;
      return part;
    };
    LinearPart part = fit(Eigen::MatrixXd::Zero(to.values.rows(), from.values.rows()));
    if (!options.margin.empty()) {
      LinearPart with_margin = fit(MapOfSharedMargin(options.margin, pairs, from, to));
      if (with_margin.fitted.residuals.squaredNorm() < part.fitted.residuals.squaredNorm()) part = std::move(with_margin);
    }
    const internal::LinearRidges& ridges = part.ridges;
    internal::LinearMap& fitted = part.fitted;
    linear = WithGainsUpTo(options.largest_gain, fitted.map);
    residuals = std::move(fitted.residuals);
    model.noise_variance = ridges.noise_variance.mean();
    model.linear_variance = (ridges.noise_variance.array() / ridges.ridge.array()).mean();
    model.log_marginal_likelihood = ridges.log_likelihood;
  }
  model.linear = linear.cast<float>();
  if (!stationary || count >= options.min_pairs_for_process) {
    // What the linear part misses of clips that it has not seen: is any of it a function of the step before?
    const GaussianProcessOptions rbf{.min_noise_ratio = 0.05};
    GaussianProcess process = GaussianProcess::Condition(internal::SearchKernel(captured_from, residuals(Eigen::all, captured), rbf),
                                                         from.values, residuals);
    model.length_scale = process.kernel().length_scale;
    Eigen::MatrixXd left = UnseenResiduals(process, from.values, residuals, pairs.clip);
    if (!stationary || left.squaredNorm() < (1 - options.process_gain) * residuals.squaredNorm()) {
      model.signal_variance = process.kernel().signal_variance;
      model.noise_variance = process.kernel().noise_variance;
      if (!stationary) model.log_marginal_likelihood = process.log_marginal_likelihood();
      model.process = std::move(process);
      residuals = std::move(left);
    }
  }
  model.unseen_error = residuals.squaredNorm() / static_cast<double>(residuals.size());

  // Cov(A w + f(w)) + noise = I keeps the marginal.
  if (keep_marginal) Centre(to.component, &residuals);
  const Explained explained = ExplainedBy(linear, model.process);
  const Eigen::MatrixXd wanted = SymmetricPower(
      Eigen::MatrixXd::Identity(linear.rows(), linear.rows()) - explained.covariance, 1.0, options.smallest_noise);
  if (keep_marginal) residuals = Recoloured(residuals, wanted, options.smallest_noise).colwise() - explained.mean;
  model.residuals = residuals.cast<float>();
  // Where the residuals are kept as captured, so is their density.
  const Eigen::LLT<Eigen::MatrixXd> llt(keep_marginal ? wanted
                                                              : SymmetricPower(ShrunkMoments(residuals), 1.0, options.smallest_noise));
  if (llt.info() != Eigen::Success) throw std::runtime_error("FitTransition: noise covariance is not positive definite");
  model.noise_cholesky = llt.matrixL();
  return model;
}

}  // namespace morphograph
