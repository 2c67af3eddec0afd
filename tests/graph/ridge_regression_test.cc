#include "graph/ridge_regression.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <random>
#include <stdexcept>

#include "graph/internal/linear_map.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

constexpr int kInputs = 4, kOutputs = 3, kCount = 120;
constexpr double kNoise = 0.3;

struct Data {
  Eigen::MatrixXd map, inputs, outputs;
  std::vector<int> groups;  // of three columns
};

Data LinearData() {
  std::mt19937_64 rng(11);
  Data data{testing::RandomNormal(kOutputs, kInputs, rng), testing::RandomNormal(kInputs, kCount, rng), {}, {}};
  data.outputs = data.map * data.inputs + kNoise * testing::RandomNormal(kOutputs, kCount, rng);
  for (int i = 0; i < kCount; ++i) data.groups.push_back(i / 3);
  return data;
}

TEST(RidgeRegression, FindsTheMapAndTheNoise) {
  const Data data = LinearData();
  const RidgeRegression ridge = FitRidge(data.inputs, data.outputs, data.groups);
  EXPECT_LT((ridge.map - data.map).cwiseAbs().maxCoeff(), 0.12);
  EXPECT_NEAR(ridge.noise_variance, kNoise * kNoise, 0.015);
  EXPECT_LT((ridge.Mean(data.inputs.col(0)) - ridge.map * data.inputs.col(0)).norm(), 1e-12);
}

TEST(RidgeRegression, JudgesByWhatItHasNotSeen) {
  // Outputs that have nothing to do with the inputs, of few columns: a fit would follow them, and believe in little noise.
  std::mt19937_64 rng(5);
  const Eigen::MatrixXd inputs = testing::RandomNormal(10, 24, rng), outputs = testing::RandomNormal(2, 24, rng);
  std::vector<int> groups;
  for (int i = 0; i < 24; ++i) groups.push_back(i);
  EXPECT_GT(FitRidge(inputs, outputs, groups).noise_variance, 0.9 * outputs.squaredNorm() / 48);
}

TEST(RidgeRegression, CopiesInOneGroupDoNotVouchForEachOther) {
  std::mt19937_64 rng(7);
  const Eigen::MatrixXd once_in = testing::RandomNormal(10, 12, rng), once_out = testing::RandomNormal(2, 12, rng);
  const Eigen::MatrixXd inputs = once_in.replicate(1, 5), outputs = once_out.replicate(1, 5);
  std::vector<int> together, alone;
  for (int i = 0; i < 60; ++i) together.push_back(i % 12), alone.push_back(i);
  EXPECT_LT(FitRidge(inputs, outputs, alone).noise_variance, 0.7 * FitRidge(inputs, outputs, together).noise_variance);
}

// The likelihood that ridges are chosen by is that of the N outputs together, whether there are more of them than inputs or fewer, and where inputs repeat each other.
TEST(LinearRidges, TellTheLikelihoodOfAllPairs) {
  std::mt19937_64 rng(31);
  for (const auto& [inputs, pairs, repeats] : {std::tuple{4, 30, false}, std::tuple{30, 12, false}, std::tuple{6, 40, true}, std::tuple{12, 12, false}}) {
    Eigen::MatrixXd x = testing::RandomNormal(inputs, pairs, rng);
    if (repeats) x.bottomRows(3) = 2 * x.topRows(3);
    const Eigen::MatrixXd y = testing::RandomNormal(2, inputs, rng) * x + 0.7 * testing::RandomNormal(2, pairs, rng);
    const internal::LinearRidges ridges = internal::SearchLinearRidges(x, y);
    double expected = 0;
    for (Eigen::Index e = 0; e < 2; ++e) {
      Eigen::MatrixXd covariance = ridges.noise_variance[e] / ridges.ridge[e] * (x.transpose() * x);
      covariance.diagonal().array() += ridges.noise_variance[e];
      const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
      expected -= 0.5 * y.row(e) * llt.solve(y.row(e).transpose()) + llt.matrixLLT().diagonal().array().log().sum() + 0.5 * pairs * std::log(2 * M_PI);
    }
    EXPECT_NEAR(ridges.log_likelihood, expected, 1e-6 * std::abs(expected)) << inputs << " inputs, " << pairs << " pairs";
    // No other ridge says the pairs better.
    for (const double factor : {0.8, 1.25}) {
      double other = 0;
      for (Eigen::Index e = 0; e < 2; ++e) {
        Eigen::MatrixXd covariance = x.transpose() * x;
        covariance.diagonal().array() += factor * ridges.ridge[e];
        const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
        const double scale = y.row(e).dot(llt.solve(y.row(e).transpose())) / pairs;
        other -= 0.5 * pairs * (std::log(scale) + 1 + std::log(2 * M_PI)) + llt.matrixLLT().diagonal().array().log().sum();
      }
      EXPECT_LE(other, ridges.log_likelihood + 1e-5 * std::abs(expected)) << inputs << " inputs, " << pairs << " pairs";
    }
  }
}

TEST(RidgeRegression, RefusesWhatDoesNotFit) {
  const Data data = LinearData();
  EXPECT_THROW(FitRidge(data.inputs, data.outputs.leftCols(5), data.groups), std::invalid_argument);
  EXPECT_THROW(FitRidge(data.inputs, data.outputs, {1, 2}), std::invalid_argument);
  EXPECT_THROW(FitRidge(data.inputs, data.outputs, std::vector<int>(kCount, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
