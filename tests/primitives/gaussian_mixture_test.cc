#include "primitives/gaussian_mixture.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;
using testing::RandomUniform;

MixtureComponent RandomComponent(int dimension, double log_weight, std::mt19937_64& rng) {
  const Eigen::MatrixXd a = RandomNormal(dimension, dimension, rng);
  const Eigen::MatrixXd covariance = a * a.transpose() + 0.1 * Eigen::MatrixXd::Identity(dimension, dimension);
  return {log_weight, 2 * RandomNormal(dimension, 1, rng), covariance.llt().matrixL()};
}

// Clusters about centres `distance` apart along successive axes.
Eigen::MatrixXd Clusters(int dimension, int clusters, int of_each, double distance, std::mt19937_64& rng) {
  Eigen::MatrixXd samples = RandomNormal(dimension, clusters * of_each, rng);
  for (int i = 0; i < samples.cols(); ++i) samples((i / of_each) % dimension, i) += distance * (1 + i / of_each / dimension);
  return samples;
}

TEST(GaussianMixture, DensityIsTheWeightedSumOfGaussians) {
  std::mt19937_64 rng(1);
  const GaussianMixture mixture({RandomComponent(3, std::log(2.0), rng), RandomComponent(3, std::log(6.0), rng)});
  EXPECT_NEAR(std::exp(mixture.Component(0).log_weight), 0.25, 1e-15);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d x = 2 * RandomNormal(3, 1, rng);
    double density[2];
    for (int k = 0; k < 2; ++k) {
      const Eigen::Matrix3d covariance = mixture.Component(k).cholesky * mixture.Component(k).cholesky.transpose();
      const Eigen::Vector3d d = x - mixture.Component(k).mean;
      density[k] = (k == 0 ? 0.25 : 0.75) * std::exp(-0.5 * d.dot(covariance.inverse() * d)) /
                   std::sqrt(std::pow(2 * std::numbers::pi, 3) * covariance.determinant());
    }
    EXPECT_NEAR(mixture.LogDensity(x), std::log(density[0] + density[1]), 1e-9);
    EXPECT_NEAR(mixture.LogResponsibilities(x)[1], std::log(density[1] / (density[0] + density[1])), 1e-9);
    EXPECT_EQ(mixture.MostLikely(x), density[1] > density[0] ? 1 : 0);
  }
}

TEST(GaussianMixture, StaysFiniteInLogsFarFromEverything) {
  std::mt19937_64 rng(2);
  const GaussianMixture mixture({RandomComponent(4, 0, rng), RandomComponent(4, 0, rng)});
  const Eigen::VectorXd far = Eigen::VectorXd::Constant(4, 1e6);
  EXPECT_TRUE(std::isfinite(mixture.LogDensity(far)));
  EXPECT_NEAR(mixture.LogResponsibilities(far).array().exp().sum(), 1, 1e-9);
}

TEST(GaussianMixture, SamplesHaveItsMeanAndCovariance) {
  std::mt19937_64 rng(3);
  const GaussianMixture mixture({RandomComponent(2, std::log(0.3), rng), RandomComponent(2, std::log(0.7), rng)});
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (const MixtureComponent& c : mixture.components()) {
    mean += std::exp(c.log_weight) * c.mean;
    second += std::exp(c.log_weight) * (c.mean * c.mean.transpose() + c.cholesky * c.cholesky.transpose());
  }
  const int n = 40000;
  Eigen::MatrixXd samples(2, n);
  for (int i = 0; i < n; ++i) samples.col(i) = mixture.Sample(rng);
  const double scale = std::sqrt(second.trace());
  EXPECT_LT((samples.rowwise().mean() - mean).norm(), 0.03 * scale);
  EXPECT_LT((samples * samples.transpose() / n - second).norm(), 0.05 * second.norm());
}

TEST(GaussianMixture, RefusesWhatIsNoMixture) {
  std::mt19937_64 rng(4);
  EXPECT_THROW(GaussianMixture(std::vector<MixtureComponent>()), std::invalid_argument);
  MixtureComponent bad = RandomComponent(3, 0, rng);
  bad.cholesky(1, 1) = 0;
  EXPECT_THROW(GaussianMixture({bad}), std::invalid_argument);
  EXPECT_THROW(GaussianMixture({RandomComponent(3, 0, rng), RandomComponent(2, 0, rng)}), std::invalid_argument);
  EXPECT_THROW(GaussianMixture().LogDensity(Eigen::VectorXd(0)), std::invalid_argument);
  EXPECT_THROW(GaussianMixture({RandomComponent(3, 0, rng)}).LogDensity(Eigen::VectorXd::Zero(2)), std::invalid_argument);
}

TEST(FitGaussianMixture, ObjectiveNeverFalls) {
  std::mt19937_64 rng(5);
  for (const CovarianceForm form : {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal}) {
    for (const double shrinkage : {0.0, 0.02, 0.3}) {
      for (int components = 1; components <= 4; ++components) {
        const Eigen::MatrixXd samples = Clusters(6, 3, 30, 1.5, rng);
        GaussianMixtureOptions options;
        options.shrinkage = shrinkage;
        options.tolerance = 1e-10;
        const GaussianMixtureFit fit = FitGaussianMixture(samples, components, form, options, rng);
        ASSERT_GE(fit.objective.size(), 2u);
        for (std::size_t i = 1; i < fit.objective.size(); ++i)
          EXPECT_GE(fit.objective[i], fit.objective[i - 1] - 1e-9 * std::abs(fit.objective[i - 1]))
              << CovarianceFormName(form) << " " << shrinkage << " " << components << " " << i;
        double sum = 0;
        for (int i = 0; i < samples.cols(); ++i) sum += fit.mixture.LogDensity(samples.col(i));
        EXPECT_NEAR(fit.log_likelihood, sum, 1e-8 * std::abs(sum));
        EXPECT_GE(fit.objective.back(), fit.objective.front());
      }
    }
  }
}

TEST(FitGaussianMixture, OneGaussianIsTheSampleCovarianceShrunkToItsDiagonal) {
  std::mt19937_64 rng(6);
  const Eigen::MatrixXd samples = RandomNormal(5, 5, rng) * RandomNormal(5, 60, rng);
  GaussianMixtureOptions options;
  options.shrinkage = 0.1;
  options.relative_floor = 1e-12;
  const GaussianMixtureFit fit = FitGaussianMixture(samples, 1, CovarianceForm::kFull, options, rng);
  const Eigen::MatrixXd centred = samples.colwise() - samples.rowwise().mean();
  const Eigen::MatrixXd covariance = centred * centred.transpose() / 60;
  Eigen::MatrixXd expected = 0.9 * covariance;
  expected.diagonal() += 0.1 * covariance.diagonal();
  const Eigen::MatrixXd& factor = fit.mixture.Component(0).cholesky;
  EXPECT_LT((factor * factor.transpose() - expected).norm(), 1e-9 * expected.norm());
  EXPECT_LT((fit.mixture.Component(0).mean - samples.rowwise().mean()).norm(), 1e-12);
  EXPECT_EQ(fit.parameters, 5 + 15);
}

TEST(FitGaussianMixture, FormsAreWhatTheySay) {
  std::mt19937_64 rng(7);
  const Eigen::MatrixXd samples = Clusters(4, 2, 80, 6, rng);
  const GaussianMixtureFit tied = FitGaussianMixture(samples, 2, CovarianceForm::kTied, {}, rng);
  EXPECT_EQ((tied.mixture.Component(0).cholesky - tied.mixture.Component(1).cholesky).norm(), 0);
  EXPECT_EQ(tied.parameters, 1 + 8 + 10);
  const GaussianMixtureFit diagonal = FitGaussianMixture(samples, 2, CovarianceForm::kDiagonal, {}, rng);
  for (const MixtureComponent& c : diagonal.mixture.components())
    EXPECT_EQ((c.cholesky - Eigen::MatrixXd(c.cholesky.diagonal().asDiagonal())).norm(), 0);
  EXPECT_EQ(diagonal.parameters, 1 + 8 + 8);
}

TEST(FitGaussianMixture, FindsWellSeparatedClusters) {
  std::mt19937_64 rng(8);
  const Eigen::MatrixXd samples = Clusters(3, 3, 100, 12, rng);
  const GaussianMixtureFit fit = FitGaussianMixture(samples, 3, CovarianceForm::kFull, {}, rng);
  for (int cluster = 0; cluster < 3; ++cluster) {
    const Eigen::VectorXd mean = samples.middleCols(100 * cluster, 100).rowwise().mean();
    const int k = fit.mixture.MostLikely(mean);
    EXPECT_LT((fit.mixture.Component(k).mean - mean).norm(), 1e-6);
    EXPECT_NEAR(std::exp(fit.mixture.Component(k).log_weight), 1.0 / 3, 1e-6);
  }
}

TEST(FitGaussianMixture, RecoversAKnownMixtureAndItsDensityOfNewSamples) {
  std::mt19937_64 rng(14);
  std::vector<MixtureComponent> parts;
  for (const double weight : {0.5, 0.3, 0.2}) parts.push_back(RandomComponent(3, std::log(weight), rng));
  // Near enough to overlap: k-means alone would cut them apart in the wrong places.
  parts[0].mean = Eigen::Vector3d(0, 0, 0);
  parts[1].mean = Eigen::Vector3d(4, 0, 1);
  parts[2].mean = Eigen::Vector3d(0, -4, 3);
  const GaussianMixture truth(parts);
  const auto draw = [&](int count) {
    Eigen::MatrixXd samples(3, count);
    for (int i = 0; i < count; ++i) samples.col(i) = truth.Sample(rng);
    return samples;
  };
  const auto mean_log_density = [](const GaussianMixture& mixture, const Eigen::MatrixXd& samples) {
    double sum = 0;
    for (Eigen::Index i = 0; i < samples.cols(); ++i) sum += mixture.LogDensity(samples.col(i));
    return sum / static_cast<double>(samples.cols());
  };
  const Eigen::MatrixXd seen = draw(6000), unseen = draw(4000);
  GaussianMixtureOptions options;
  options.shrinkage = 0;
  const GaussianMixture found = FitGaussianMixture(seen, 3, CovarianceForm::kFull, options, rng).mixture;
  for (const MixtureComponent& part : truth.components()) {
    const auto distance = [&](const MixtureComponent& c) { return (c.mean - part.mean).norm(); };
    const MixtureComponent& nearest = *std::min_element(
        found.components().begin(), found.components().end(),
        [&](const MixtureComponent& a, const MixtureComponent& b) { return distance(a) < distance(b); });
    const Eigen::Matrix3d covariance = part.cholesky * part.cholesky.transpose();
    EXPECT_LT(distance(nearest), 0.1 * std::sqrt(covariance.trace()));
    EXPECT_NEAR(std::exp(nearest.log_weight), std::exp(part.log_weight), 0.025);
    EXPECT_LT((nearest.cholesky * nearest.cholesky.transpose() - covariance).norm(), 0.12 * covariance.norm());
  }
  const double best = mean_log_density(truth, unseen);
  const GaussianMixture one = FitGaussianMixture(seen, 1, CovarianceForm::kFull, options, rng).mixture;
  EXPECT_GT(mean_log_density(found, unseen), best - 0.01);
  EXPECT_LT(mean_log_density(one, unseen), best - 0.1);
}

TEST(FitGaussianMixture, TakesFewerSamplesThanDimensionsDuplicatesAndOne) {
  std::mt19937_64 rng(9);
  const Eigen::MatrixXd few = RandomNormal(20, 6, rng);
  for (const CovarianceForm form : {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal}) {
    EXPECT_TRUE(std::isfinite(FitGaussianMixture(few, 3, form, {}, rng).log_likelihood));
    const GaussianMixtureFit one = FitGaussianMixture(few.leftCols(1), 3, form, {}, rng);
    EXPECT_EQ(one.mixture.size(), 1);
    EXPECT_TRUE(std::isfinite(one.log_likelihood));
    const GaussianMixtureFit duplicated = FitGaussianMixture(few.leftCols(2).replicate(1, 20), 4, form, {}, rng);
    EXPECT_EQ(duplicated.mixture.size(), 2);
    EXPECT_TRUE(std::isfinite(duplicated.log_likelihood));
  }
}

TEST(FitGaussianMixture, SurvivesComponentsThatLoseTheirSamples) {
  // One far sample apiece and many components: some must run empty or nearly so on the way.
  std::mt19937_64 rng(10);
  for (int repeat = 0; repeat < 20; ++repeat) {
    Eigen::MatrixXd samples = RandomNormal(2, 40, rng);
    samples.col(0) *= 50;
    samples.col(1) = samples.col(0);
    for (const CovarianceForm form : {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal}) {
      const GaussianMixtureFit fit = FitGaussianMixture(samples, 8, form, {}, rng);
      EXPECT_TRUE(std::isfinite(fit.log_likelihood));
      for (std::size_t i = 1; i < fit.objective.size(); ++i)
        EXPECT_GE(fit.objective[i], fit.objective[i - 1] - 1e-9 * std::abs(fit.objective[i - 1]));
    }
  }
}

TEST(SelectGaussianMixture, KeepsToTheFewestComponentsAskedFor) {
  std::mt19937_64 rng(12);
  GaussianMixtureOptions options;
  options.min_components = 3;
  options.max_components = 4;
  const GaussianMixtureSelection one_cluster = SelectGaussianMixture(RandomNormal(4, 300, rng), options, rng);
  EXPECT_EQ(one_cluster.best.mixture.size(), 3);
  for (const GaussianMixtureCandidate& candidate : one_cluster.candidates) {  // the best of those that are allowed
    if (candidate.components >= 3) EXPECT_GE(candidate.bic, one_cluster.best.bic);
  }
  Eigen::MatrixXd two_values(2, 40);
  for (Eigen::Index i = 0; i < two_values.cols(); ++i) two_values.col(i).setConstant(i % 2);
  EXPECT_EQ(SelectGaussianMixture(two_values, options, rng).best.mixture.size(), 2);
  {  // Larger numbers are tried until two that are allowed do not gain
    for (const CovarianceForm form : {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal}) {
      EXPECT_TRUE(std::any_of(one_cluster.candidates.begin(), one_cluster.candidates.end(),
                              [&](const GaussianMixtureCandidate& c) { return c.form == form && c.components == 4; }));
    }
  }
  options.min_components = 5;  // more than max_components
  EXPECT_THROW(SelectGaussianMixture(two_values, options, rng), std::invalid_argument);
  options.min_components = 0;
  EXPECT_THROW(SelectGaussianMixture(two_values, options, rng), std::invalid_argument);
}

TEST(SelectGaussianMixture, ChoosesTheNumberAndFormThatMadeTheData) {
  std::mt19937_64 rng(11);
  const GaussianMixtureSelection three = SelectGaussianMixture(Clusters(4, 3, 120, 6, rng), {}, rng);
  EXPECT_EQ(three.best.mixture.size(), 3);
  // Correlated, but not so nearly singular that the shrinkage of a single Gaussian would cost more than a second one.
  const Eigen::MatrixXd mix = Eigen::MatrixXd::Identity(4, 4) + Eigen::MatrixXd::Constant(4, 4, 0.5);
  const GaussianMixtureSelection full = SelectGaussianMixture(mix * RandomNormal(4, 400, rng), {}, rng);
  EXPECT_EQ(full.best.mixture.size(), 1);
  EXPECT_EQ(full.best.form, CovarianceForm::kFull);
  const GaussianMixtureSelection diagonal = SelectGaussianMixture(RandomNormal(30, 300, rng), {}, rng);
  EXPECT_EQ(diagonal.best.mixture.size(), 1);
  EXPECT_EQ(diagonal.best.form, CovarianceForm::kDiagonal);
  for (const GaussianMixtureCandidate& candidate : diagonal.candidates) EXPECT_GE(candidate.bic, diagonal.best.bic);
}

TEST(SelectGaussianMixture, SameSeedGivesTheSameMixture) {
  std::mt19937_64 data(12), first(1), second(1);
  const Eigen::MatrixXd samples = Clusters(5, 3, 50, 2, data);
  const GaussianMixtureSelection a = SelectGaussianMixture(samples, {}, first), b = SelectGaussianMixture(samples, {}, second);
  EXPECT_EQ(a.best.log_likelihood, b.best.log_likelihood);
  ASSERT_EQ(a.best.mixture.size(), b.best.mixture.size());
  for (int k = 0; k < a.best.mixture.size(); ++k)
    EXPECT_EQ((a.best.mixture.Component(k).cholesky - b.best.mixture.Component(k).cholesky).norm(), 0);
}

TEST(SelectGaussianMixture, RefusesBadOptions) {
  std::mt19937_64 rng(13);
  const Eigen::MatrixXd samples = RandomNormal(3, 10, rng);
  GaussianMixtureOptions options;
  options.shrinkage = 1;
  EXPECT_THROW(SelectGaussianMixture(samples, options, rng), std::invalid_argument);
  EXPECT_THROW(SelectGaussianMixture(Eigen::MatrixXd(3, 0), {}, rng), std::invalid_argument);
  EXPECT_THROW(SelectGaussianMixture(samples / 0.0, {}, rng), std::invalid_argument);
  options = {};
  options.forms.clear();
  EXPECT_THROW(SelectGaussianMixture(samples, options, rng), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
