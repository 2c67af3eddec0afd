#include "graph/ridge_regression.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

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

TEST(RidgeRegression, RefusesWhatDoesNotFit) {
  const Data data = LinearData();
  EXPECT_THROW(FitRidge(data.inputs, data.outputs.leftCols(5), data.groups), std::invalid_argument);
  EXPECT_THROW(FitRidge(data.inputs, data.outputs, {1, 2}), std::invalid_argument);
  EXPECT_THROW(FitRidge(data.inputs, data.outputs, std::vector<int>(kCount, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
