#include "primitives/cubic_resample.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;

Eigen::VectorXd Positions(double from, double to, int count) { return Eigen::VectorXd::LinSpaced(count, from, to); }

TEST(UniformCubicSpline, ReproducesPolynomialsUpToItsOrder) {
  const Eigen::Vector4d coefficients(0.7, -1.1, 0.4, 0.05);
  for (int samples : {1, 2, 3, 4, 5, 8, 25}) {
    const int degree = std::min(samples - 1, 3);
    const auto polynomial = [&](double x) {
      double sum = 0;
      for (int d = degree; d >= 0; --d) sum = sum * x + coefficients[d];
      return sum;
    };
    const auto derivative = [&](double x) {
      double sum = 0;
      for (int d = degree; d >= 1; --d) sum = sum * x + d * coefficients[d];
      return sum;
    };
    Eigen::MatrixXd values(1, samples);
    for (int i = 0; i < samples; ++i) values(0, i) = polynomial(i);
    const UniformCubicSpline spline(samples);
    const Eigen::VectorXd positions = Positions(0, samples - 1, 41);
    const Eigen::MatrixXd got = values * spline.Weights(positions);
    const Eigen::MatrixXd slope = values * spline.DerivativeWeights(positions);
    for (int k = 0; k < positions.size(); ++k) {
      EXPECT_NEAR(got(0, k), polynomial(positions[k]), 1e-12 * (1 + values.cwiseAbs().maxCoeff())) << samples;
      EXPECT_NEAR(slope(0, k), derivative(positions[k]), 1e-11 * (1 + values.cwiseAbs().maxCoeff())) << samples;
    }
  }
}

TEST(UniformCubicSpline, InterpolatesAsItsWeightsDo) {
  std::mt19937_64 rng(4);
  for (int samples : {1, 2, 3, 4, 5, 6, 25}) {
    const Eigen::MatrixXd values = RandomNormal(7, samples, rng);
    const UniformCubicSpline spline(samples);
    const Eigen::VectorXd positions = Positions(-1, samples, 61);
    EXPECT_LT((spline.Interpolate(values, positions) - values * spline.Weights(positions)).cwiseAbs().maxCoeff(), 1e-12) << samples;
  }
  EXPECT_THROW(UniformCubicSpline(5).Interpolate(RandomNormal(7, 4, rng), Positions(0, 1, 2)), std::invalid_argument);
}

TEST(UniformCubicSpline, PassesThroughTheSamplesAndIsTwiceContinuous) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd values = RandomNormal(3, 12, rng);
  const UniformCubicSpline spline(12);
  EXPECT_EQ((values * spline.Weights(Positions(0, 11, 12)) - values).norm(), 0.0);
  const double h = 1e-6;
  for (int i = 1; i < 11; ++i) {
    const Eigen::MatrixXd d =
        values * spline.DerivativeWeights((Eigen::VectorXd(4) << i - 2 * h, i - h, i + h, i + 2 * h).finished());
    const Eigen::Vector3d second_left = (d.col(1) - d.col(0)) / h, second_right = (d.col(3) - d.col(2)) / h;
    EXPECT_LT((d.col(2) - d.col(1)).norm(), 1e-4);
    EXPECT_LT((second_left - second_right).norm(), 1e-3) << i;
  }
}

TEST(UniformCubicSpline, HoldsTheBorderValuesOutside) {
  const UniformCubicSpline spline(5);
  const Eigen::RowVectorXd values = (Eigen::RowVectorXd(5) << 3, 1, 4, 1, 5).finished();
  const Eigen::MatrixXd got = values * spline.Weights(Eigen::Vector3d(-0.4, 4.0, 7.5));
  EXPECT_EQ(got(0, 0), 3);
  EXPECT_EQ(got(0, 1), 5);
  EXPECT_EQ(got(0, 2), 5);
  EXPECT_THROW(UniformCubicSpline(0), std::invalid_argument);
}

TEST(ResampleCubic, OfAPartEqualsTheSplineOfTheWhole) {
  std::mt19937_64 rng(2);
  const Eigen::MatrixXd data = RandomNormal(4, 120, rng);
  const Eigen::VectorXd positions = Positions(50.3, 66.9, 25);
  const Eigen::MatrixXd whole = data * UniformCubicSpline(120).Weights(positions);
  EXPECT_LT((ResampleCubic(data, positions) - whole).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_EQ(ResampleCubic(data, Eigen::VectorXd()).cols(), 0);
  EXPECT_THROW(ResampleCubic(Eigen::MatrixXd(4, 0), positions), std::invalid_argument);
  // Wholly outside: the border's value.
  EXPECT_EQ((ResampleCubic(data, Eigen::Vector2d(-90, 900)).col(1) - data.col(119)).norm(), 0.0);
}

}  // namespace
}  // namespace morphograph
