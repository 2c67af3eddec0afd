#include "synthesis/frechet_distance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace morphograph {
namespace {

GaussianFit Normal(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  return {mean, covariance};
}

TEST(FrechetDistance, OfCommutingGaussiansIsTheClosedForm) {
  // Diagonal covariances commute: |m1 - m2|^2 + sum (s1 - s2)^2 = (9 + 16) + (1 - 2)^2 + (3 - 0.5)^2.
  const GaussianFit a = Normal(Eigen::Vector2d(3, 0), Eigen::Vector2d(1, 9).asDiagonal());
  const GaussianFit b = Normal(Eigen::Vector2d(0, 4), Eigen::Vector2d(4, 0.25).asDiagonal());
  EXPECT_NEAR(FrechetDistance(a, b), 25 + 1 + 6.25, 1e-12);
}

TEST(FrechetDistance, OfTwoDimensionalGaussiansThatDoNotCommute) {
  // For 2 x 2 matrices tr (A B)^1/2 = sqrt(tr AB + 2 sqrt(det AB)).
  Eigen::Matrix2d a, b;
  a << 2, 1, 1, 3;
  b << 4, -1, -1, 1;
  const double cross = std::sqrt((a * b).trace() + 2 * std::sqrt((a * b).determinant()));
  const double expected = a.trace() + b.trace() - 2 * cross;
  const Eigen::Vector2d zero = Eigen::Vector2d::Zero();
  EXPECT_NEAR(FrechetDistance(Normal(zero, a), Normal(zero, b)), expected, 1e-12);
  EXPECT_NEAR(FrechetDistance(Normal(zero, b), Normal(zero, a)), expected, 1e-12);
}

TEST(FrechetDistance, IsZeroForItselfEvenWhenSingular) {
  Eigen::Matrix3d singular = Eigen::Matrix3d::Zero();
  singular.topLeftCorner<2, 2>() << 1, 1, 1, 1;
  const GaussianFit fit = Normal(Eigen::Vector3d(1, 2, 3), singular);
  EXPECT_NEAR(FrechetDistance(fit, fit), 0, 1e-7);
}

TEST(FrechetDistance, RefusesDifferentDimensions) {
  EXPECT_THROW(FrechetDistance(Normal(Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity()),
                               Normal(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity())),
               std::invalid_argument);
}

TEST(FitGaussian, RecoversMeanAndCovarianceOfSamples) {
  std::mt19937_64 rng(3);
  boost::random::normal_distribution<double> normal;
  Eigen::Matrix2d factor;
  factor << 2, 0, 1, 0.5;
  Eigen::MatrixXd samples(2, 100000);
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    const double u = normal(rng), v = normal(rng);
    samples.col(i) = Eigen::Vector2d(5, -1) + factor * Eigen::Vector2d(u, v);
  }
  const GaussianFit fit = FitGaussian(samples);
  EXPECT_LT((fit.mean - Eigen::Vector2d(5, -1)).norm(), 0.03);
  EXPECT_LT((fit.covariance - factor * factor.transpose()).norm(), 0.08);
}

TEST(FitGaussian, RefusesTooFewAndBrokenSamples) {
  EXPECT_THROW(FitGaussian(Eigen::MatrixXd::Zero(3, 1)), std::invalid_argument);
  Eigen::MatrixXd broken = Eigen::MatrixXd::Zero(3, 4);
  broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(FitGaussian(broken), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
