// Fitting of Gaussian mixtures; the mixture itself is in gaussian_mixture.cc.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "primitives/gaussian_mixture.h"
#include "primitives/k_means.h"

namespace morphograph {
namespace {

constexpr int kTrialIterations = 5;   // of every start, before the best is carried on
constexpr int kMeansIterations = 10;   // Lloyd's, to settle a start
constexpr double kEmptySamples = 0.5;  // a component with less than half a sample has lost them all

// Conjugate prior of the covariances, fixed during one run of EM. Adds to the log likelihood, for each component,
// -1/2 (strength ln|C| + tr(C^-1 (strength diag(scatter) + floor I))).
struct CovariancePrior {
  double strength = 0;      // in samples
  Eigen::VectorXd scatter;  // (D) variances
  double floor = 0;

  Eigen::VectorXd Pull() const { return strength * scatter.array() + floor; }
};

// A model during the fit. Of `cholesky`, full keeps one factor a component, tied a single one; diagonal keeps
// `deviations` (D x K) instead.
struct State {
  CovarianceForm form = CovarianceForm::kFull;
  Eigen::MatrixXd means;         // (D x K)
  Eigen::VectorXd log_weights;   // (K)
  std::vector<Eigen::MatrixXd> cholesky;
  Eigen::MatrixXd deviations;

  Eigen::Index components() const { return means.cols(); }
};

Eigen::MatrixXd Factor(const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success)
    throw std::runtime_error("GaussianMixture: a covariance is not positive definite; raise relative_floor or shrinkage");
  return llt.matrixL();
}

class Fitter {
 public:
  Fitter(const Eigen::MatrixXd& samples, const GaussianMixtureOptions& options) : samples_(samples), options_(options) {
    mean_variance_ = (samples.colwise() - samples.rowwise().mean()).squaredNorm() / static_cast<double>(samples.size());
    // Equal samples have no scale of their own; any positive floor keeps their covariance definite.
    floor_ = options.relative_floor * (mean_variance_ > 0 ? mean_variance_ : 1.0);
  }

  struct Run {
    State state;
    CovariancePrior prior;
    Eigen::MatrixXd log_joint;  // (K x N) at `state`
    double log_likelihood = -std::numeric_limits<double>::infinity();
    std::vector<double> objective;
    int iterations = 0;
    int reseeds = 0;
    bool converged = false;
  };

  Run Start(int components, CovarianceForm form, std::mt19937_64& rng) const {
    const KMeans clusters = FitKMeans(samples_, components, kMeansIterations, rng);
    const Eigen::Index n = samples_.cols(), k_count = clusters.centres.cols();
    Run run;
    run.state.form = form;
    run.state.means.setZero(samples_.rows(), k_count);
    Eigen::MatrixXd responsibilities = Eigen::MatrixXd::Zero(k_count, n);
    for (Eigen::Index i = 0; i < n; ++i) responsibilities(clusters.of_sample[i], i) = 1;

    const Eigen::VectorXd counts = responsibilities.rowwise().sum();
    const Eigen::MatrixXd means = (samples_ * responsibilities.transpose()) * counts.cwiseMax(1e-300).cwiseInverse().asDiagonal();
    const Eigen::MatrixXd within = samples_ - means * responsibilities;
    run.prior.scatter = within.rowwise().squaredNorm() / static_cast<double>(n);
    const double share = static_cast<double>(n) / static_cast<double>(k_count);
    run.prior.strength = options_.shrinkage / (1 - options_.shrinkage) * share;
    run.prior.floor = floor_ * share;

    // Factors to fall back on, should a cluster be empty from the start.
    const Eigen::VectorXd deviations = (run.prior.scatter.array() + floor_).sqrt();
    run.state.log_weights = Eigen::VectorXd::Constant(k_count, -std::log(static_cast<double>(k_count)));
    if (form == CovarianceForm::kDiagonal) {
      run.state.deviations = deviations.replicate(1, k_count);
    } else {
      run.state.cholesky.assign(form == CovarianceForm::kTied ? 1 : k_count, deviations.asDiagonal());
    }
    Maximise(responsibilities, &run);
    Expect(&run);
    return run;
  }

  // Up to `limit` iterations more.
  void Iterate(int limit, Run* run) const {
    const double enough = options_.tolerance * static_cast<double>(samples_.cols());
    for (int i = 0; i < limit && !run->converged; ++i) {
      Eigen::MatrixXd responsibilities = run->log_joint;
      for (Eigen::Index s = 0; s < responsibilities.cols(); ++s)
        responsibilities.col(s) = (responsibilities.col(s).array() - LogDensityOf(*run, s)).exp();
      Maximise(responsibilities, run);
      Expect(run);
      ++run->iterations;
      const std::size_t count = run->objective.size();
      run->converged = count > 1 && run->objective[count - 1] - run->objective[count - 2] < enough;
    }
  }

  GaussianMixtureFit Finish(const Run& run) const {
    const State& state = run.state;
    const auto d = static_cast<int>(samples_.rows());
    const auto k_count = static_cast<int>(state.components());
    std::vector<MixtureComponent> components(static_cast<std::size_t>(k_count));
    for (int k = 0; k < k_count; ++k) {
      components[k].log_weight = state.log_weights[k];
      components[k].mean = state.means.col(k);
      if (state.form == CovarianceForm::kDiagonal) {
        components[k].cholesky = state.deviations.col(k).asDiagonal();
      } else {
        components[k].cholesky = state.cholesky[state.form == CovarianceForm::kTied ? 0 : k];
      }
    }
    GaussianMixtureFit fit;
    fit.mixture = GaussianMixture(std::move(components));
    fit.form = state.form;
    fit.log_likelihood = run.log_likelihood;
    const int covariance_parameters = state.form == CovarianceForm::kDiagonal ? k_count * d
                                      : state.form == CovarianceForm::kTied   ? d * (d + 1) / 2
                                                                              : k_count * (d * (d + 1) / 2);
    fit.parameters = k_count - 1 + k_count * d + covariance_parameters;
    fit.bic = -2 * fit.log_likelihood + fit.parameters * std::log(static_cast<double>(samples_.cols()));
    fit.iterations = run.iterations;
    fit.converged = run.converged;
    fit.objective = run.objective;
    return fit;
  }

 private:
  static double LogDensityOf(const Run& run, Eigen::Index sample) {
    const double largest = run.log_joint.col(sample).maxCoeff();
    return largest + std::log((run.log_joint.col(sample).array() - largest).exp().sum());
  }

  // M step, Eq. 4.31-4.33 with the prior.
  void Maximise(const Eigen::MatrixXd& responsibilities, Run* run) const {
    State& state = run->state;
    const Eigen::Index n = samples_.cols(), d = samples_.rows();
    const Eigen::VectorXd counts = responsibilities.rowwise().sum();
    const Eigen::VectorXd pull = run->prior.Pull();
    const double strength = run->prior.strength;
    Eigen::MatrixXd tied = Eigen::MatrixXd::Zero(d, d);
    Eigen::MatrixXd weighted(d, n);
    for (Eigen::Index k = 0; k < state.components(); ++k) {
      // A component without samples has no mean and no covariance of its own: leave it as it is.
      const bool empty = counts[k] < kEmptySamples;
      if (!empty) state.means.col(k).noalias() = samples_ * responsibilities.row(k).transpose() / counts[k];
      state.log_weights[k] = std::log(std::max(counts[k], 1e-300) / static_cast<double>(n));
      if (empty && state.form != CovarianceForm::kTied) continue;
      weighted = (samples_.colwise() - state.means.col(k)) * responsibilities.row(k).cwiseSqrt().asDiagonal();
      if (state.form == CovarianceForm::kDiagonal) {
        state.deviations.col(k) = ((weighted.rowwise().squaredNorm() + pull) / (counts[k] + strength)).cwiseSqrt();
      } else if (state.form == CovarianceForm::kTied) {
        tied.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
      } else {
        Eigen::MatrixXd covariance = pull.asDiagonal();
        covariance.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
        state.cholesky[k] = Factor(covariance / (counts[k] + strength));
      }
    }
    if (state.form == CovarianceForm::kTied) {
      const auto k_count = static_cast<double>(state.components());
      tied.diagonal() += k_count * pull;
      state.cholesky[0] = Factor(tied / (counts.sum() + k_count * strength));
    }
    Reseed(counts, run);
  }

  // Puts components that lost their samples where the mixture explains the data worst. Likelihood may fall here, so the
  // record of the objective starts anew; each run does this a bounded number of times.
  void Reseed(const Eigen::VectorXd& counts, Run* run) const {
    State& state = run->state;
    if (!(counts.minCoeff() < kEmptySamples) || run->log_joint.cols() != samples_.cols()) return;
    if (run->reseeds >= state.components()) return;
    std::vector<Eigen::Index> worst(static_cast<std::size_t>(samples_.cols()));
    for (std::size_t i = 0; i < worst.size(); ++i) worst[i] = static_cast<Eigen::Index>(i);
    std::stable_sort(worst.begin(), worst.end(), [&](Eigen::Index a, Eigen::Index b) {
      return LogDensityOf(*run, a) < LogDensityOf(*run, b);
    });
    std::size_t next = 0;
    const Eigen::VectorXd deviations = (run->prior.scatter.array() + floor_).sqrt();
    for (Eigen::Index k = 0; k < state.components() && next < worst.size(); ++k) {
      if (counts[k] >= kEmptySamples) continue;
      state.means.col(k) = samples_.col(worst[next++]);
      state.log_weights[k] = -std::log(static_cast<double>(samples_.cols()));
      if (state.form == CovarianceForm::kDiagonal) state.deviations.col(k) = deviations;
      if (state.form == CovarianceForm::kFull) state.cholesky[k] = deviations.asDiagonal();
      ++run->reseeds;
    }
    const double largest = state.log_weights.maxCoeff();
    state.log_weights.array() -= largest + std::log((state.log_weights.array() - largest).exp().sum());
    run->objective.clear();
  }

  // E step, Eq. 4.30, in logs; and what the objective is now.
  void Expect(Run* run) const {
    const State& state = run->state;
    const Eigen::Index n = samples_.cols(), d = samples_.rows();
    const double constant = -0.5 * static_cast<double>(d) * std::log(2 * std::numbers::pi);
    const Eigen::VectorXd pull = run->prior.Pull();
    double log_prior = 0;
    run->log_joint.resize(state.components(), n);
    Eigen::MatrixXd whitened;
    if (state.form == CovarianceForm::kTied) whitened = state.cholesky[0].triangularView<Eigen::Lower>().solve(samples_);
    Eigen::MatrixXd inverse_factor;
    double log_determinant = 0, pull_trace = 0;  // ln|C|, tr(C^-1 diag(pull))
    for (Eigen::Index k = 0; k < state.components(); ++k) {
      Eigen::RowVectorXd squared;
      if (state.form == CovarianceForm::kDiagonal) {
        const Eigen::VectorXd inverse = state.deviations.col(k).cwiseInverse();
        squared = (inverse.asDiagonal() * (samples_.colwise() - state.means.col(k))).colwise().squaredNorm();
        log_determinant = 2 * state.deviations.col(k).array().log().sum();
        pull_trace = (inverse.array().square() * pull.array()).sum();
      } else {
        const Eigen::MatrixXd& factor = state.cholesky[state.form == CovarianceForm::kTied ? 0 : k];
        if (state.form == CovarianceForm::kTied) {
          const Eigen::VectorXd centre = factor.triangularView<Eigen::Lower>().solve(state.means.col(k));
          squared = (whitened.colwise() - centre).colwise().squaredNorm();
        } else {
          whitened = samples_.colwise() - state.means.col(k);
          factor.triangularView<Eigen::Lower>().solveInPlace(whitened);
          squared = whitened.colwise().squaredNorm();
        }
        if (k == 0 || state.form == CovarianceForm::kFull) {
          log_determinant = 2 * factor.diagonal().array().log().sum();
          inverse_factor = pull.cwiseSqrt().asDiagonal();
          factor.triangularView<Eigen::Lower>().solveInPlace(inverse_factor);
          pull_trace = inverse_factor.squaredNorm();
        }
      }
      log_prior -= 0.5 * (run->prior.strength * log_determinant + pull_trace);
      run->log_joint.row(k) = (state.log_weights[k] + constant - 0.5 * log_determinant) - 0.5 * squared.array();
    }
    run->log_likelihood = 0;
    for (Eigen::Index s = 0; s < n; ++s) run->log_likelihood += LogDensityOf(*run, s);  // Eq. 4.34
    run->objective.push_back(run->log_likelihood + log_prior);
  }

  const Eigen::MatrixXd& samples_;
  const GaussianMixtureOptions& options_;
  double mean_variance_ = 0;
  double floor_ = 0;
};

void Check(const Eigen::MatrixXd& samples, int components, const GaussianMixtureOptions& options) {
  const auto fail = [](const std::string& problem) { throw std::invalid_argument("GaussianMixture: " + problem); };
  if (samples.cols() < 1 || samples.rows() < 1)
    fail("samples are " + std::to_string(samples.rows()) + " x " + std::to_string(samples.cols()) + "; needs at least one of each");
  if (!samples.allFinite()) fail("samples hold values that are not finite");
  if (components < 1) fail("asked for " + std::to_string(components) + " components; must be >= 1");
  if (!(options.shrinkage >= 0 && options.shrinkage < 1)) fail("shrinkage must be in [0, 1)");
  if (!(options.relative_floor > 0)) fail("relative_floor must be > 0");
  if (options.restarts < 1 || options.max_iterations < 1) fail("restarts and max_iterations must be >= 1");
  if (options.forms.empty()) fail("no covariance forms given");
}

}  // namespace

GaussianMixtureFit FitGaussianMixture(const Eigen::MatrixXd& samples, int components, CovarianceForm form,
                                      const GaussianMixtureOptions& options, std::mt19937_64& rng) {
  Check(samples, components, options);
  const Fitter fitter(samples, options);
  const int starts = components == 1 ? 1 : options.restarts;
  Fitter::Run best;
  for (int start = 0; start < starts; ++start) {
    Fitter::Run run = fitter.Start(components, form, rng);
    fitter.Iterate(std::min(kTrialIterations, options.max_iterations), &run);
    if (start == 0 || run.log_likelihood > best.log_likelihood) best = std::move(run);
  }
  fitter.Iterate(options.max_iterations - best.iterations, &best);
  return fitter.Finish(best);
}

GaussianMixtureSelection SelectGaussianMixture(const Eigen::MatrixXd& samples, const GaussianMixtureOptions& options,
                                               std::mt19937_64& rng) {
  Check(samples, options.max_components, options);
  if (options.min_components < 1 || options.min_components > options.max_components) {
    throw std::invalid_argument("GaussianMixture: min_components must be in 1..max_components");
  }
  GaussianMixtureSelection out;
  const auto enough = [&](const GaussianMixtureFit& fit) { return std::min(fit.mixture.size(), options.min_components); };
  const auto better = [&](const GaussianMixtureFit& fit) {
    return enough(fit) != enough(out.best) ? enough(fit) > enough(out.best) : fit.bic < out.best.bic;
  };
  const bool has_full = std::find(options.forms.begin(), options.forms.end(), CovarianceForm::kFull) != options.forms.end();
  for (const CovarianceForm form : options.forms) {
    double best_of_form = std::numeric_limits<double>::infinity();
    int without_gain = 0;
    for (int k = 1; k <= options.max_components && without_gain < options.bic_patience; ++k) {
      if (k == 1 && form == CovarianceForm::kTied && has_full) continue;  // the same model
      GaussianMixtureFit fit = FitGaussianMixture(samples, k, form, options, rng);
      if (fit.mixture.size() < k) break;  // no more distinct samples
      out.candidates.push_back({form, k, fit.log_likelihood, fit.bic});
      if (k >= options.min_components) {
        without_gain = fit.bic < best_of_form ? 0 : without_gain + 1;
        best_of_form = std::min(best_of_form, fit.bic);
      }
      if (out.best.mixture.size() == 0 || better(fit)) out.best = std::move(fit);
    }
  }
  return out;
}

}  // namespace morphograph
