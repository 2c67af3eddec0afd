#pragma once

#include <Eigen/Core>
#include <random>
#include <string_view>
#include <vector>

namespace morphograph {

enum class CovarianceForm { kFull, kTied, kDiagonal };
std::string_view CovarianceFormName(CovarianceForm form);  // "full", "tied", "diagonal"

/// One Gaussian of a mixture.
struct MixtureComponent {
  double log_weight = 0;
  Eigen::VectorXd mean;      // (D)
  Eigen::MatrixXd cholesky;  // (D x D) lower L, covariance = L L^T
};

/// Mixture of Gaussians, p(x) = sum_k w_k N(x | mean_k, covariance_k) (Du 3.4.1). Immutable; an empty one has no components.
class GaussianMixture {
 public:
  GaussianMixture() = default;
  /// Weights are normalised to sum to 1.
  /// @throws std::invalid_argument when `components` is empty, sizes differ, or a factor's diagonal is not positive.
  explicit GaussianMixture(std::vector<MixtureComponent> components);

  int dimension() const { return components_.empty() ? 0 : static_cast<int>(components_[0].mean.size()); }
  int size() const { return static_cast<int>(components_.size()); }
  const std::vector<MixtureComponent>& components() const { return components_; }
  const MixtureComponent& Component(int index) const { return components_[index]; }

  /// ln p(x). @throws std::invalid_argument when the size differs or the mixture is empty; so do the others.
  double LogDensity(const Eigen::VectorXd& x) const;
  /// ln p(component k | x), (K) (Du Eq. 4.30, in logs).
  Eigen::VectorXd LogResponsibilities(const Eigen::VectorXd& x) const;
  /// ln (w_k N(x | k)), (K): LogDensity is their log-sum-exp.
  Eigen::VectorXd LogJoint(const Eigen::VectorXd& x) const;
  /// Component of the greatest responsibility, the first of equals.
  int MostLikely(const Eigen::VectorXd& x) const;

  Eigen::VectorXd Sample(std::mt19937_64& rng) const;
  /// From one component alone.
  Eigen::VectorXd SampleComponent(int index, std::mt19937_64& rng) const;

 private:
  std::vector<MixtureComponent> components_;
  std::vector<double> log_scale_;  // log weight + log of the Gaussian's normaliser
};

struct GaussianMixtureOptions {
  int min_components = 1;        // of a selection; where the samples have fewer distinct values, as many as they have
  int max_components = 5;
  std::vector<CovarianceForm> forms = {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal};
  /// Share of the prior in a covariance of full size: one Gaussian gets (1 - s) S + s diag(S). [0, 1)
  double shrinkage = 0.02;
  double relative_floor = 1e-6;  // variance added everywhere, times the mean variance of the samples; > 0
  int restarts = 3;              // k-means++ starts for each number of components
  int max_iterations = 200;      // of EM, the best start's
  double tolerance = 1e-5;       // stop when the objective gains less than this per sample
  int bic_patience = 2;          // give up on larger K after so many from min_components on without a better BIC
};

/// One fitted mixture, and how it was fitted.
struct GaussianMixtureFit {
  GaussianMixture mixture;
  CovarianceForm form = CovarianceForm::kFull;
  double log_likelihood = 0;  // of all samples
  double bic = 0;             // -2 log likelihood + parameters * ln N: smaller is better
  int parameters = 0;
  int iterations = 0;
  bool converged = false;
  std::vector<double> objective;  // after every iteration; never falls
};

/// What was tried while choosing K and form.
struct GaussianMixtureCandidate {
  CovarianceForm form = CovarianceForm::kFull;
  int components = 0;
  double log_likelihood = 0;
  double bic = 0;
};

struct GaussianMixtureSelection {
  GaussianMixtureFit best;
  std::vector<GaussianMixtureCandidate> candidates;  // in the order tried
};

/// Expectation-maximisation (Du 3.4.2, Eq. 4.30-4.34) for a given number of components and form.
///
/// Covariances are regularised by a conjugate prior that stays fixed during the fit, so the objective (log likelihood plus
/// log prior) never falls: covariance_k = (N_k S_k + n Psi + f I) / (N_k + n), with Psi the diagonal of the covariance within
/// the starting clusters, n = s / (1 - s) * N / K and f the floor. With one component that is shrinkage to the diagonal.
/// With s = 0 the prior is the floor alone. A component that loses all its samples starts again at the sample that the
/// mixture explains worst. Of all starts the best after five iterations is carried to the end.
///
/// @param samples  (D x N), N >= 1, finite. Fewer components come back where the samples have fewer distinct values.
GaussianMixtureFit FitGaussianMixture(const Eigen::MatrixXd& samples, int components, CovarianceForm form,
                                      const GaussianMixtureOptions& options, std::mt19937_64& rng);

/// Chooses K in min_components..max_components and the form by the Bayesian information criterion (Du 3.4.3; Eq. 3.35-3.36 with the
/// noise variance taken out, as is usual for likelihoods: -2 ln L + d ln N). @throws std::invalid_argument as FitGaussianMixture, and when
/// min_components is not in 1..max_components.
GaussianMixtureSelection SelectGaussianMixture(const Eigen::MatrixXd& samples, const GaussianMixtureOptions& options,
                                               std::mt19937_64& rng);

}  // namespace morphograph
