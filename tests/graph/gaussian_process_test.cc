#include "graph/gaussian_process.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <thread>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;

// Two smooth functions of two variables.
Eigen::MatrixXd Smooth(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd y(2, x.cols());
  y.row(0) = x.row(0).array().sin() + 0.5 * x.row(1).array();
  y.row(1) = (x.row(0).array() * x.row(1).array() * 0.3).cos() - 0.5;
  return y;
}

TEST(LogMarginalLikelihood, IsTheGaussianDensityOfTheOutputs) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd x = RandomNormal(2, 6, rng), y = RandomNormal(3, 6, rng);
  const GaussianProcessKernel kernel{1.3, 0.8, 0.4, 0.2};
  Eigen::MatrixXd covariance(6, 6);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      covariance(i, j) = 1.3 * std::exp(-(x.col(i) - x.col(j)).squaredNorm() / (2 * 0.8 * 0.8)) + 0.4 * x.col(i).dot(x.col(j)) +
                         (i == j ? 0.2 : 0.0);
  double expected = 0;
  for (int e = 0; e < 3; ++e)
    expected -= 0.5 * y.row(e) * covariance.inverse() * y.row(e).transpose() + 0.5 * std::log(covariance.determinant()) +
                3 * std::log(2 * std::numbers::pi);
  EXPECT_NEAR(LogMarginalLikelihood(x, y, kernel), expected, 1e-9);
  EXPECT_NEAR(GaussianProcess::Condition(kernel, x, y).log_marginal_likelihood(), expected, 1e-9);
}

TEST(LogMarginalLikelihood, GradientAgreesWithCentralDifferences) {
  std::mt19937_64 rng(2);
  const Eigen::MatrixXd x = RandomNormal(3, 15, rng), y = RandomNormal(4, 15, rng);
  const Eigen::Vector4d logs(0.3, -0.2, -1.5, -0.7);
  const auto kernel = [](const Eigen::Vector4d& l) {  // order of the gradient: signal, length, noise, linear
    return GaussianProcessKernel{std::exp(l[0]), std::exp(l[1]), std::exp(l[3]), std::exp(l[2])};
  };
  Eigen::Vector4d gradient;
  LogMarginalLikelihood(x, y, kernel(logs), &gradient);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector4d step = 1e-5 * Eigen::Vector4d::Unit(i);
    const double numeric =
        (LogMarginalLikelihood(x, y, kernel(logs + step)) - LogMarginalLikelihood(x, y, kernel(logs - step))) / 2e-5;
    EXPECT_NEAR(gradient[i], numeric, 1e-6 * (1 + std::abs(numeric))) << i;
  }
}

TEST(GaussianProcess, NearlyNoiselessReproducesItsData) {
  std::mt19937_64 rng(3);
  const Eigen::MatrixXd x = RandomNormal(2, 60, rng), y = Smooth(x);
  const GaussianProcess process = GaussianProcess::Condition({1, 1, 0, 1e-8}, x, y);
  for (int i = 0; i < 60; ++i) {
    const GaussianPrediction at = process.Predict(x.col(i));
    EXPECT_LT((at.mean - y.col(i)).norm(), 1e-4);
    EXPECT_LT(at.variance, 1e-6);
  }
  const GaussianPrediction far = process.Predict(Eigen::Vector2d(50, 50));
  EXPECT_LT(far.mean.norm(), 1e-12);
  EXPECT_NEAR(far.variance, 1, 1e-12);
}

TEST(GaussianProcess, PredictionIsTheConditionalGaussian) {
  std::mt19937_64 rng(4);
  const Eigen::MatrixXd x = RandomNormal(3, 12, rng), y = RandomNormal(2, 12, rng);
  const GaussianProcessKernel kernel{0.7, 1.4, 0.3, 0.1};
  const auto k = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return 0.7 * std::exp(-(a - b).squaredNorm() / (2 * 1.4 * 1.4)) + 0.3 * a.dot(b);
  };
  Eigen::MatrixXd covariance(12, 12);
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) covariance(i, j) = k(x.col(i), x.col(j)) + (i == j ? 0.1 : 0);
  const GaussianProcess process = GaussianProcess::Condition(kernel, x, y);
  const Eigen::Vector3d at(0.3, -0.4, 0.9);
  Eigen::VectorXd vector(12);
  for (int i = 0; i < 12; ++i) vector[i] = k(x.col(i), at);
  const GaussianPrediction got = process.Predict(at);
  EXPECT_LT((got.mean - y * covariance.inverse() * vector).norm(), 1e-10);
  EXPECT_NEAR(got.variance, k(at, at) - vector.dot(covariance.inverse() * vector), 1e-10);
  EXPECT_EQ((process.PredictMean(at) - got.mean).norm(), 0);
}

TEST(GaussianProcess, JacobianOfTheMeanAgreesWithCentralDifferences) {
  std::mt19937_64 rng(7);
  const Eigen::MatrixXd x = RandomNormal(2, 12, rng);
  for (const double linear : {0.0, 0.4}) {
    const GaussianProcess process = GaussianProcess::Condition({1.2, 0.9, linear, 0.05}, x, Smooth(x));
    const Eigen::Vector2d at(0.3, -0.4);
    const Eigen::MatrixXd jacobian = process.MeanJacobian(at);
    constexpr double kStep = 1e-5;
    for (int d = 0; d < 2; ++d) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(d);
      const Eigen::VectorXd difference = (process.PredictMean(at + step) - process.PredictMean(at - step)) / (2 * kStep);
      EXPECT_LT((jacobian.col(d) - difference).norm(), 1e-8);
    }
  }
}

TEST(GaussianProcess, SearchFindsTheKernelThatMadeTheData) {
  std::mt19937_64 rng(5);
  const int n = 180, outputs = 20;
  const Eigen::MatrixXd x = 2 * RandomNormal(2, n, rng);
  Eigen::MatrixXd covariance(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      covariance(i, j) = 4 * std::exp(-(x.col(i) - x.col(j)).squaredNorm() / (2 * 1.5 * 1.5)) + (i == j ? 0.25 : 0);
  const Eigen::MatrixXd factor = covariance.llt().matrixL();
  const Eigen::MatrixXd y = (factor * RandomNormal(n, outputs, rng)).transpose();
  const GaussianProcess process = GaussianProcess::Fit(x, y);
  EXPECT_NEAR(std::log(process.kernel().length_scale), std::log(1.5), 0.1);
  EXPECT_NEAR(std::log(process.kernel().signal_variance), std::log(4.0), 0.3);
  EXPECT_NEAR(std::log(process.kernel().noise_variance), std::log(0.25), 0.1);
  // And it is a maximum: the gradient vanishes, per output value.
  Eigen::Vector4d gradient;
  const double best = LogMarginalLikelihood(x, y, process.kernel(), &gradient);
  EXPECT_NEAR(best, process.log_marginal_likelihood(), 1e-6 * std::abs(best));
  EXPECT_LT(gradient.head<3>().cwiseAbs().maxCoeff() / static_cast<double>(y.size()), 1e-3);
}

TEST(GaussianProcess, LinearKernelExtrapolatesALine) {
  std::mt19937_64 rng(6);
  const Eigen::MatrixXd x = RandomNormal(2, 80, rng);
  const Eigen::MatrixXd map = RandomNormal(3, 2, rng);
  const Eigen::MatrixXd y = map * x + 0.01 * RandomNormal(3, 80, rng);
  const GaussianProcess process = GaussianProcess::Fit(x, y, {.linear = true});
  const Eigen::Vector2d far(12, -9);
  EXPECT_LT((process.PredictMean(far) - map * far).norm(), 0.05 * (map * far).norm());
}

TEST(GaussianProcess, OfPureNoisePredictsNearZero) {
  std::mt19937_64 rng(7);
  const Eigen::MatrixXd x = RandomNormal(10, 150, rng), y = RandomNormal(8, 150, rng);
  const GaussianProcess process = GaussianProcess::Fit(x, y);
  double mean_square = 0;
  for (int i = 0; i < 50; ++i) mean_square += process.PredictMean(RandomNormal(10, 1, rng)).squaredNorm() / 8 / 50;
  EXPECT_LT(mean_square, 0.05);
}

TEST(GaussianProcess, PredictsWhatItHasNotSeenFarBetterThanTheMean) {
  std::mt19937_64 rng(11);
  const double noise = 0.1;
  const Eigen::MatrixXd x = RandomNormal(2, 250, rng), y = Smooth(x) + noise * RandomNormal(2, 250, rng);
  const Eigen::VectorXd mean = y.rowwise().mean();
  const GaussianProcess process = GaussianProcess::Fit(x, y.colwise() - mean);
  const Eigen::MatrixXd unseen = RandomNormal(2, 400, rng), truth = Smooth(unseen);
  double of_process = 0, of_mean = 0;
  for (int i = 0; i < 400; ++i) {
    of_process += (mean + process.PredictMean(unseen.col(i)) - truth.col(i)).squaredNorm() / 800;
    of_mean += (mean - truth.col(i)).squaredNorm() / 800;
  }
  EXPECT_LT(of_process, 0.02 * of_mean);
  EXPECT_LT(of_process, 0.5 * noise * noise);  // averages the noise away: nearer to the function than any one observation
  EXPECT_NEAR(std::sqrt(process.kernel().noise_variance), noise, 0.02);
}

// Squared errors over predicted variances, and how often an error is below one and below 1.96 deviations.
struct Calibration {
  double mean_square = 0, within_1 = 0, within_196 = 0, mean_log_density = 0;
};

Calibration Calibrate(const GaussianProcess& process, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  Calibration sum;
  const double share = 1.0 / static_cast<double>(y.size());
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const GaussianPrediction at = process.Predict(x.col(i));
    const double variance = at.variance + process.kernel().noise_variance;
    for (Eigen::Index e = 0; e < y.rows(); ++e) {
      const double z2 = std::pow(y(e, i) - at.mean[e], 2) / variance;
      sum.mean_square += share * z2;
      sum.within_1 += z2 < 1 ? share : 0;
      sum.within_196 += z2 < 1.96 * 1.96 ? share : 0;
      sum.mean_log_density -= share * 0.5 * (z2 + std::log(2 * std::numbers::pi * variance));
    }
  }
  return sum;
}

TEST(GaussianProcess, PredictedVariancesAreThoseOfItsErrors) {
  // Functions drawn from a known process; half of the unseen inputs lie where pairs are dense, half where there are few or none.
  std::mt19937_64 rng(12);
  const int seen = 150, unseen = 200, outputs = 40;
  Eigen::MatrixXd x = RandomNormal(2, seen + unseen, rng);
  x.rightCols(unseen / 2) *= 3;
  const GaussianProcessKernel kernel{2, 0.9, 0.3, 0.1};
  Eigen::MatrixXd covariance(x.cols(), x.cols());
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = 0; j < x.cols(); ++j)
      covariance(i, j) = 2 * std::exp(-(x.col(i) - x.col(j)).squaredNorm() / (2 * 0.9 * 0.9)) + 0.3 * x.col(i).dot(x.col(j)) +
                         (i == j ? 0.1 : 0);
  const Eigen::MatrixXd factor = covariance.llt().matrixL();
  const Eigen::MatrixXd y = (factor * RandomNormal(x.cols(), outputs, rng)).transpose();
  const Eigen::MatrixXd new_x = x.rightCols(unseen), new_y = y.rightCols(unseen);

  const GaussianProcess known = GaussianProcess::Condition(kernel, x.leftCols(seen), y.leftCols(seen));
  const GaussianProcess found = GaussianProcess::Fit(x.leftCols(seen), y.leftCols(seen), {.linear = true});
  for (const GaussianProcess* process : {&known, &found}) {
    const Calibration calibration = Calibrate(*process, new_x, new_y);
    EXPECT_NEAR(calibration.mean_square, 1, 0.1);
    EXPECT_NEAR(calibration.within_1, 0.683, 0.03);
    EXPECT_NEAR(calibration.within_196, 0.95, 0.02);
  }
  // In each part by itself too: the variance says where the process knows little.
  for (const int first : {0, unseen / 2}) {
    const Eigen::MatrixXd part_x = new_x.middleCols(first, unseen / 2), part_y = new_y.middleCols(first, unseen / 2);
    EXPECT_NEAR(Calibrate(known, part_x, part_y).mean_square, 1, 0.1) << first;
  }
  // Of many pairs only the density is known to follow: the variance of inducing points is an upper bound.
  const GaussianProcess sparse = GaussianProcess::Condition(kernel, x.leftCols(seen), y.leftCols(seen),
                                                            {.max_exact_pairs = seen - 1, .inducing_points = 60});
  const Calibration bound = Calibrate(sparse, new_x, new_y);
  EXPECT_LT(bound.mean_square, 1.1);
  EXPECT_GT(bound.within_196, 0.93);
  EXPECT_GT(Calibrate(known, new_x, new_y).mean_log_density, bound.mean_log_density);
}

TEST(GaussianProcess, InducingPointsComeCloseToTheExactProcess) {
  std::mt19937_64 rng(8);
  const Eigen::MatrixXd x = RandomNormal(2, 500, rng), y = Smooth(x) + 0.1 * RandomNormal(2, 500, rng);
  const GaussianProcessKernel kernel{1, 1, 0, 0.01};
  const GaussianProcess exact = GaussianProcess::Condition(kernel, x, y);
  const GaussianProcess sparse = GaussianProcess::Condition(kernel, x, y, {.max_exact_pairs = 499, .inducing_points = 120});
  EXPECT_EQ(sparse.points(), 120);
  EXPECT_NEAR(sparse.log_marginal_likelihood(), exact.log_marginal_likelihood(), 0.02 * std::abs(exact.log_marginal_likelihood()));
  for (int i = 0; i < 50; ++i) {
    const Eigen::VectorXd at = RandomNormal(2, 1, rng);
    EXPECT_LT((sparse.PredictMean(at) - exact.PredictMean(at)).norm(), 0.05);
    EXPECT_GE(sparse.Predict(at).variance, exact.Predict(at).variance - 1e-9);
  }
  // With every point inducing, the approximation is none.
  const GaussianProcess all = GaussianProcess::Condition(kernel, x, y, {.max_exact_pairs = 499, .inducing_points = 500});
  EXPECT_NEAR(all.log_marginal_likelihood(), exact.log_marginal_likelihood(), 1e-3 * std::abs(exact.log_marginal_likelihood()));
  EXPECT_LT((all.PredictMean(x.col(3)) - exact.PredictMean(x.col(3))).norm(), 1e-3);
}

TEST(GaussianProcess, TakesDuplicatesEqualInputsOnePairAndZeroOutputs) {
  std::mt19937_64 rng(9);
  const Eigen::MatrixXd x = RandomNormal(3, 10, rng), y = RandomNormal(2, 10, rng);
  const GaussianProcess duplicated = GaussianProcess::Fit(x.replicate(1, 5), y.replicate(1, 5));
  EXPECT_TRUE(duplicated.Predict(x.col(0)).mean.allFinite());
  const GaussianProcess equal = GaussianProcess::Fit(x.col(0).replicate(1, 10), y);
  EXPECT_LT((equal.PredictMean(x.col(0)) - y.rowwise().mean()).norm(), y.rowwise().mean().norm() + 1e-9);
  EXPECT_TRUE(GaussianProcess::Fit(x.col(0), y.col(0)).Predict(x.col(0)).mean.allFinite());
  const GaussianPrediction zero = GaussianProcess::Fit(x, Eigen::MatrixXd::Zero(2, 10)).Predict(x.col(1));
  EXPECT_EQ(zero.mean.norm(), 0);
  EXPECT_TRUE(std::isfinite(zero.variance));
  const GaussianProcess same = GaussianProcess::Condition({1, 1, 0, 1e-300}, x.replicate(1, 3), y.replicate(1, 3));  // needs jitter
  EXPECT_LT((same.PredictMean(x.col(2)) - y.col(2)).norm(), 1e-2);
}

TEST(GaussianProcess, RebuiltFromItsPartsIsTheSameFromManyThreads) {
  std::mt19937_64 rng(10);
  const Eigen::MatrixXd x = RandomNormal(4, 90, rng), y = RandomNormal(5, 90, rng);
  const GaussianProcess process = GaussianProcess::Fit(x, y);
  const GaussianProcess again = GaussianProcess::Fit(x, y);
  EXPECT_EQ((process.alpha() - again.alpha()).norm(), 0);
  const GaussianProcess rebuilt(process.kernel(), process.inputs(), process.alpha(), process.log_marginal_likelihood());
  const Eigen::VectorXd at = RandomNormal(4, 1, rng);
  const GaussianPrediction expected = process.Predict(at);
  std::vector<GaussianPrediction> got(4);
  std::vector<std::thread> threads;
  for (GaussianPrediction& slot : got) threads.emplace_back([&slot, &rebuilt, &at] { slot = rebuilt.Predict(at); });
  for (std::thread& thread : threads) thread.join();
  for (const GaussianPrediction& prediction : got) {
    EXPECT_EQ((prediction.mean - expected.mean).norm(), 0);
    EXPECT_EQ(prediction.variance, expected.variance);
  }
}

TEST(GaussianProcess, RefusesPairsThatDoNotFit) {
  const Eigen::MatrixXd x = Eigen::MatrixXd::Identity(3, 3);
  EXPECT_THROW(GaussianProcess::Fit(x, Eigen::MatrixXd::Zero(2, 4)), std::invalid_argument);
  EXPECT_THROW(GaussianProcess::Fit(Eigen::MatrixXd(3, 0), Eigen::MatrixXd(2, 0)), std::invalid_argument);
  EXPECT_THROW(GaussianProcess::Fit(x, x / 0.0), std::invalid_argument);
  EXPECT_THROW(GaussianProcess::Condition({1, 0, 0, 0.1}, x, x), std::invalid_argument);
  EXPECT_THROW(GaussianProcess::Condition({1, 1, 0, 0}, x, x), std::invalid_argument);
  EXPECT_THROW(GaussianProcess::Condition({1, 1, 0, 0.1}, x, x).Predict(Eigen::Vector2d(0, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
