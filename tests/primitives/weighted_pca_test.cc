#include "primitives/weighted_pca.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "primitives/matrix_factors.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;
using testing::RandomUniform;

// Samples with a decaying spectrum about a mean that is not zero.
Eigen::MatrixXd Samples(int dimension, int count, std::mt19937_64& rng) {
  Eigen::VectorXd scales(dimension);
  for (int i = 0; i < dimension; ++i) scales[i] = std::pow(0.7, i);
  return (RandomNormal(dimension, dimension, rng) * scales.asDiagonal() * RandomNormal(dimension, count, rng)).array() + 2.0;
}

Eigen::VectorXd Weights(int dimension, std::mt19937_64& rng) {
  Eigen::VectorXd weights(dimension);
  for (double& w : weights) w = RandomUniform(0.1, 5, rng);
  return weights;
}

WeightedPcaOptions Everything() { return {.variance_kept = 1.0}; }

TEST(WeightedPca, BasisIsOrthonormalInTheWeightedInnerProduct) {
  std::mt19937_64 rng(1);
  for (const auto& [dimension, count] : {std::pair{12, 40}, std::pair{60, 20}, std::pair{20, 20}}) {
    const Eigen::MatrixXd samples = Samples(dimension, count, rng);
    const WeightedPca pca = FitWeightedPca(samples, Weights(dimension, rng), Everything());
    EXPECT_EQ(pca.components(), std::min(dimension, count - 1));
    const Eigen::MatrixXd gram = pca.basis.transpose() * pca.weights.asDiagonal() * pca.basis;
    EXPECT_LT((gram - Eigen::MatrixXd::Identity(pca.components(), pca.components())).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(WeightedPca, LatentsAreUncorrelatedWithTheStatedVariances) {
  std::mt19937_64 rng(2);
  const Eigen::MatrixXd samples = Samples(15, 50, rng);
  const WeightedPca pca = FitWeightedPca(samples, Weights(15, rng), Everything());
  const Eigen::MatrixXd latents = pca.ProjectAll(samples);
  EXPECT_LT(latents.rowwise().mean().cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::MatrixXd covariance = latents * latents.transpose() / 50;
  EXPECT_LT((covariance - Eigen::MatrixXd(pca.variances.asDiagonal())).cwiseAbs().maxCoeff(), 1e-10 * pca.variances[0]);
  for (int k = 1; k < pca.components(); ++k) EXPECT_LE(pca.variances[k], pca.variances[k - 1]);
}

TEST(WeightedPca, WithEqualWeightsIsPlainPca) {
  std::mt19937_64 rng(3);
  const Eigen::MatrixXd samples = Samples(8, 100, rng);
  const WeightedPca pca = FitWeightedPca(samples, Eigen::VectorXd::Ones(8), Everything());
  const Eigen::MatrixXd centred = samples.colwise() - samples.rowwise().mean();
  const SymmetricFactors eigen = FactorSymmetric(centred * centred.transpose() / 100);
  for (int k = 0; k < 8; ++k) {
    EXPECT_NEAR(pca.variances[k], eigen.values[7 - k], 1e-10 * eigen.values[7]);
    EXPECT_NEAR(std::abs(pca.basis.col(k).dot(eigen.vectors.col(7 - k))), 1, 1e-8);
  }
}

TEST(WeightedPca, IsTheBestReconstructionOfItsRankInTheWeightedNorm) {
  std::mt19937_64 rng(4);
  const Eigen::MatrixXd samples = Samples(10, 60, rng);
  const Eigen::VectorXd weights = Weights(10, rng);
  const WeightedPca pca = FitWeightedPca(samples, weights, {.variance_kept = 1.0, .max_components = 3});
  ASSERT_EQ(pca.components(), 3);
  // Error for any other oblique basis of rank 3, with the weighted projection that is best for it.
  const Eigen::MatrixXd centred = weights.cwiseSqrt().asDiagonal() * (samples.colwise() - pca.mean);
  const auto error_of = [&](const Eigen::MatrixXd& basis) {
    const Eigen::MatrixXd scaled = weights.cwiseSqrt().asDiagonal() * basis;
    return (centred - scaled * (scaled.transpose() * scaled).llt().solve(scaled.transpose() * centred)).squaredNorm();
  };
  double error = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::VectorXd rest = samples.col(i) - pca.Reconstruct(pca.Project(samples.col(i)));
    error += (weights.array() * rest.array().square()).sum();
  }
  EXPECT_NEAR(error, error_of(pca.basis), 1e-9 * error);
  EXPECT_NEAR(error / centred.squaredNorm(), 1 - pca.variance_kept, 1e-12);
  for (int repeat = 0; repeat < 50; ++repeat) EXPECT_GT(error_of(pca.basis + 0.05 * RandomNormal(10, 3, rng)), error);
  // Plain PCA is worse in this norm.
  const WeightedPca plain = FitWeightedPca(samples, Eigen::VectorXd::Ones(10), {.variance_kept = 1.0, .max_components = 3});
  EXPECT_GT(error_of(plain.basis), error * 1.01);
}

TEST(WeightedPca, LeavesLessOfUnseenSamplesThanPlainPcaOrRandomAxes) {
  std::mt19937_64 rng(10);
  // Noise on the dimensions of little weight, as on the leaves of a body: plain PCA spends its axes on it.
  const int dimension = 16, rank = 4;
  const Eigen::MatrixXd motion = RandomNormal(dimension, rank, rng);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(dimension), noise = Eigen::VectorXd::Constant(dimension, 0.1);
  weights.tail(6).setConstant(0.001);
  noise.tail(6).setConstant(6);
  const auto draw = [&](int count) -> Eigen::MatrixXd {
    return motion * RandomNormal(rank, count, rng) + noise.asDiagonal() * RandomNormal(dimension, count, rng);
  };
  const Eigen::MatrixXd seen = draw(80), unseen = draw(400);
  const auto left = [&](const WeightedPca& pca) {
    const Eigen::MatrixXd scaled = weights.cwiseSqrt().asDiagonal() * pca.basis;
    const Eigen::MatrixXd centred = weights.cwiseSqrt().asDiagonal() * (unseen.colwise() - pca.mean);
    return (centred - scaled * (scaled.transpose() * scaled).llt().solve(scaled.transpose() * centred)).squaredNorm() / centred.squaredNorm();
  };
  const WeightedPcaOptions options{.variance_kept = 1.0, .max_components = rank};
  const WeightedPca weighted = FitWeightedPca(seen, weights, options);
  const WeightedPca plain = FitWeightedPca(seen, Eigen::VectorXd::Ones(dimension), options);
  EXPECT_LT(left(weighted), 0.05);
  EXPECT_GT(left(plain), 3 * left(weighted));
  WeightedPca random = weighted;
  for (int repeat = 0; repeat < 20; ++repeat) {
    random.basis = RandomNormal(dimension, rank, rng);
    EXPECT_GT(left(random), 3 * left(weighted));
  }
}

TEST(WeightedPca, KeepsJustEnoughComponents) {
  std::mt19937_64 rng(5);
  const Eigen::MatrixXd samples = Samples(20, 80, rng);
  const Eigen::VectorXd weights = Weights(20, rng);
  const WeightedPca all = FitWeightedPca(samples, weights, Everything());
  const WeightedPca some = FitWeightedPca(samples, weights, {.variance_kept = 0.9});
  const double total = all.variances.sum();
  EXPECT_GE(some.variance_kept, 0.9);
  EXPECT_NEAR(some.variances.sum() / total, some.variance_kept, 1e-12);
  EXPECT_LT(some.variances.head(some.components() - 1).sum() / total, 0.9);
  EXPECT_NEAR(all.variance_kept, 1, 1e-12);
}

TEST(WeightedPca, ReconstructsSamplesAndInvertsProjection) {
  std::mt19937_64 rng(6);
  const Eigen::MatrixXd samples = Samples(30, 12, rng);
  const WeightedPca pca = FitWeightedPca(samples, Weights(30, rng), Everything());
  for (int i = 0; i < 12; ++i)
    EXPECT_LT((pca.Reconstruct(pca.Project(samples.col(i))) - samples.col(i)).norm(), 1e-9 * samples.norm());
  const Eigen::VectorXd latent = RandomNormal(pca.components(), 1, rng);
  EXPECT_LT((pca.Project(pca.Reconstruct(latent)) - latent).norm(), 1e-9);
  EXPECT_THROW(pca.Project(Eigen::VectorXd::Zero(29)), std::invalid_argument);
  EXPECT_THROW(pca.Reconstruct(Eigen::VectorXd::Zero(40)), std::invalid_argument);
}

TEST(WeightedPca, ADimensionOfWeightZeroFollowsWithoutLeading) {
  std::mt19937_64 rng(7);
  Eigen::MatrixXd samples = Samples(6, 40, rng);
  samples.row(5) = 3 * samples.row(0) - samples.row(2);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(6);
  weights[5] = 0;
  const WeightedPca pca = FitWeightedPca(samples, weights, Everything());
  const WeightedPca without = FitWeightedPca(samples.topRows(5), weights.head(5), Everything());
  EXPECT_LT((pca.variances - without.variances).norm(), 1e-10);
  Eigen::VectorXd sample = samples.col(3);
  sample[5] = 1e6;  // has no say
  EXPECT_NEAR(pca.Reconstruct(pca.Project(sample))[5], samples(5, 3), 1e-8);
}

TEST(WeightedPca, FixesSignsByTheLargestWeightedEntry) {
  std::mt19937_64 rng(8);
  const Eigen::MatrixXd samples = Samples(9, 30, rng);
  const Eigen::VectorXd weights = Weights(9, rng);
  const WeightedPca pca = FitWeightedPca(samples, weights), mirrored = FitWeightedPca(-samples, weights);
  EXPECT_LT((pca.basis - mirrored.basis).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(WeightedPca, TakesEqualSingleAndDuplicateSamples) {
  std::mt19937_64 rng(9);
  const Eigen::VectorXd one = 1e3 * RandomNormal(7, 1, rng);
  const WeightedPca single = FitWeightedPca(one, Eigen::VectorXd::Ones(7));
  EXPECT_EQ(single.components(), 0);
  EXPECT_EQ(single.variance_kept, 1);
  EXPECT_EQ((single.Reconstruct(Eigen::VectorXd(0)) - one).norm(), 0);
  EXPECT_EQ(FitWeightedPca(one.replicate(1, 30), Eigen::VectorXd::Ones(7)).components(), 0);
  const Eigen::MatrixXd few = RandomNormal(7, 3, rng);
  const WeightedPca duplicated = FitWeightedPca(few.replicate(1, 10), Eigen::VectorXd::Ones(7), Everything());
  EXPECT_EQ(duplicated.components(), 2);
  EXPECT_TRUE(duplicated.basis.allFinite());
  const WeightedPca weightless = FitWeightedPca(few, Eigen::VectorXd::Zero(7));
  EXPECT_EQ(weightless.components(), 0);
}

TEST(WeightedPca, SaysWhichArgumentIsWrong) {
  const Eigen::MatrixXd samples = Eigen::MatrixXd::Identity(5, 5);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(5);
  weights[3] = -0.1;
  try {
    FitWeightedPca(samples, weights);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "WeightedPca: weight 3 is -0.1; must be >= 0");
  }
  EXPECT_THROW(FitWeightedPca(samples, Eigen::VectorXd::Ones(4)), std::invalid_argument);
  EXPECT_THROW(FitWeightedPca(Eigen::MatrixXd(5, 0), Eigen::VectorXd::Ones(5)), std::invalid_argument);
  EXPECT_THROW(FitWeightedPca(samples, Eigen::VectorXd::Ones(5), {.variance_kept = 1.5}), std::invalid_argument);
  EXPECT_THROW(FitWeightedPca(samples / 0.0, Eigen::VectorXd::Ones(5)), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
