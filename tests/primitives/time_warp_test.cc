#include "primitives/time_warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;
using testing::RandomUniform;

Eigen::MatrixXd RandomCosts(int rows, int columns, std::mt19937_64& rng) {
  Eigen::MatrixXd cost(rows, columns);
  for (double& c : cost.reshaped()) c = RandomUniform(0, 1, rng);
  return cost;
}

// Least cost over every path, by trying them all; infinity where there is none.
double BruteForce(const Eigen::MatrixXd& cost, int max_slope) {
  double best = std::numeric_limits<double>::infinity();
  const std::function<void(int, int, int, int, double)> walk = [&](int i, int j, int vertical, int horizontal, double sum) {
    if (i >= cost.rows() || j >= cost.cols() || vertical > max_slope || horizontal > max_slope) return;
    sum += cost(i, j);
    if (i + 1 == cost.rows() && j + 1 == cost.cols()) {
      best = std::min(best, sum);
      return;
    }
    walk(i + 1, j + 1, 0, 0, sum);
    walk(i + 1, j, vertical + 1, 0, sum);
    walk(i, j + 1, 0, horizontal + 1, sum);
  };
  walk(0, 0, 0, 0, 0);
  return best;
}

void ExpectLegal(const WarpPath& path, const Eigen::MatrixXd& cost, int max_slope) {
  ASSERT_FALSE(path.cells.empty());
  EXPECT_EQ(path.cells.front(), (WarpCell{0, 0}));
  EXPECT_EQ(path.cells.back(), (WarpCell{static_cast<int>(cost.rows()) - 1, static_cast<int>(cost.cols()) - 1}));
  double sum = cost(0, 0);
  int vertical = 0, horizontal = 0;
  for (std::size_t k = 1; k < path.cells.size(); ++k) {
    const int di = path.cells[k].reference - path.cells[k - 1].reference;
    const int dj = path.cells[k].test - path.cells[k - 1].test;
    ASSERT_TRUE((di == 0 || di == 1) && (dj == 0 || dj == 1) && di + dj > 0);
    vertical = dj == 0 ? vertical + 1 : 0;
    horizontal = di == 0 ? horizontal + 1 : 0;
    ASSERT_LE(std::max(vertical, horizontal), max_slope);
    sum += cost(path.cells[k].reference, path.cells[k].test);
  }
  EXPECT_NEAR(sum, path.cost, 1e-12);
}

TEST(DynamicTimeWarp, FindsTheCheapestLegalPathOfAll) {
  std::mt19937_64 rng(1);
  for (int max_slope = 0; max_slope <= 5; ++max_slope) {
    for (int rows = 1; rows <= 7; ++rows) {
      for (int columns = 1; columns <= 7; ++columns) {
        const Eigen::MatrixXd cost = RandomCosts(rows, columns, rng);
        const double expected = BruteForce(cost, max_slope);
        ASSERT_EQ(CanWarp(rows, columns, {max_slope}), std::isfinite(expected)) << rows << "x" << columns << " " << max_slope;
        if (std::isfinite(expected)) {
          const WarpPath path = DynamicTimeWarp(cost, {max_slope});
          EXPECT_NEAR(path.cost, expected, 1e-12) << rows << "x" << columns << " " << max_slope;
          ExpectLegal(path, cost, max_slope);
        } else {
          EXPECT_THROW(DynamicTimeWarp(cost, {max_slope}), std::invalid_argument);
        }
      }
    }
  }
}

TEST(DynamicTimeWarp, KeepsTheSlopeLimitWhereACorridorTemptsItNotTo) {
  Eigen::MatrixXd cost = Eigen::MatrixXd::Ones(20, 20);
  cost.row(0).setZero();
  cost.col(19).setZero();
  const WarpPath free = DynamicTimeWarp(cost, {20});
  EXPECT_EQ(free.cost, 0);
  const WarpPath limited = DynamicTimeWarp(cost, {5});
  EXPECT_GT(limited.cost, 1);
  ExpectLegal(limited, cost, 5);
}

TEST(DynamicTimeWarp, MatchesASequenceWithItselfDiagonally) {
  Eigen::MatrixXd cost(9, 9);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) cost(i, j) = (i - j) * (i - j);
  const WarpPath path = DynamicTimeWarp(cost);
  EXPECT_EQ(path.cells.size(), 9u);
  EXPECT_EQ(path.cost, 0);
}

TEST(DynamicTimeWarp, RefusesEmptyInfiniteAndHopelessInput) {
  EXPECT_THROW(DynamicTimeWarp(Eigen::MatrixXd()), std::invalid_argument);
  Eigen::MatrixXd cost = Eigen::MatrixXd::Zero(4, 4);
  cost(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(DynamicTimeWarp(cost), std::invalid_argument);
  EXPECT_THROW(DynamicTimeWarp(Eigen::MatrixXd::Zero(4, 4), {-1}), std::invalid_argument);
  try {
    DynamicTimeWarp(Eigen::MatrixXd::Zero(40, 3));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("40 reference frames and 3 test frames"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(CanWarp(18, 3));
  EXPECT_FALSE(CanWarp(19, 3));
}

TEST(ChooseReference, TakesTheLeastMeanDistanceAndTheFirstOfEquals) {
  Eigen::Matrix3d distances;
  distances << 0, 1, 4, 1, 0, 2, 4, 2, 0;
  EXPECT_EQ(ChooseReference(distances), 1);
  EXPECT_EQ(ChooseReference(Eigen::Matrix3d::Zero()), 0);
  EXPECT_THROW(ChooseReference(Eigen::MatrixXd(0, 0)), std::invalid_argument);
  EXPECT_THROW(ChooseReference(Eigen::MatrixXd::Zero(2, 3)), std::invalid_argument);
}

TEST(TimeWarp, RunsForwardFromZeroToOneWhateverTheLogSlopes) {
  std::mt19937_64 rng(2);
  for (const double scale : {0.0, 1e-14, 1e-6, 0.3, 3.0, 300.0}) {
    const TimeWarp warp = TimeWarp::FromLogSlopes(scale * RandomNormal(6, 1, rng));
    EXPECT_EQ(warp(0), 0);
    EXPECT_NEAR(warp(1), 1, 1e-15);
    double previous = warp(-0.25);
    for (int i = -24; i <= 125; ++i) {
      const double next = warp(i / 100.0);
      if (scale < 10) {
        EXPECT_GT(next, previous) << scale << " " << i;
      } else {  // slopes down to e^-1000: to rounding
        EXPECT_GE(next, previous - 1e-15) << scale << " " << i;
      }
      previous = next;
    }
  }
}

TEST(TimeWarp, IntegratesItsSlopeAndInvertsExactly) {
  std::mt19937_64 rng(3);
  const TimeWarp warp = TimeWarp::FromLogSlopes(0.5 * RandomNormal(5, 1, rng));
  for (double p = -0.3; p <= 1.3; p += 0.0137) {
    const double h = 1e-5;
    EXPECT_NEAR((warp(p + h) - warp(p - h)) / (2 * h), warp.Slope(p), 2e-5 * 2);
    EXPECT_NEAR(warp.Inverse(warp(p)), p, 1e-13);
  }
  EXPECT_NEAR(warp(-0.25), -0.25 * warp.Slope(0), 1e-15);
  EXPECT_NEAR(warp(1.25), 1 + 0.25 * warp.Slope(1), 1e-15);
}

TEST(TimeWarp, IgnoresACommonConstantAndRebuildsFromItsOwnLogSlopes) {
  std::mt19937_64 rng(4);
  const Eigen::VectorXd log_slopes = RandomNormal(5, 1, rng);
  const TimeWarp warp = TimeWarp::FromLogSlopes(log_slopes);
  const TimeWarp shifted = TimeWarp::FromLogSlopes(log_slopes.array() + 700.0);
  const TimeWarp again = TimeWarp::FromLogSlopes(warp.log_slopes());
  EXPECT_LT((shifted.log_slopes() - warp.log_slopes()).norm(), 1e-12);
  EXPECT_LT((again.log_slopes() - warp.log_slopes()).norm(), 1e-14);
  EXPECT_EQ(TimeWarp()(0.37), 0.37);
  EXPECT_THROW(TimeWarp::FromLogSlopes(Eigen::VectorXd::Zero(1)), std::invalid_argument);
  EXPECT_THROW(TimeWarp::FromLogSlopes(Eigen::Vector2d(0, std::nan(""))), std::invalid_argument);
}

// The stair of whole frames that follows a warp.
WarpPath StairOf(const TimeWarp& warp, int reference_frames, int test_frames) {
  Eigen::MatrixXd cost(reference_frames, test_frames);
  for (int i = 0; i < reference_frames; ++i)
    for (int j = 0; j < test_frames; ++j)
      cost(i, j) = std::pow(warp(i / (reference_frames - 1.0)) - j / (test_frames - 1.0), 2);
  return DynamicTimeWarp(cost);
}

TEST(TimeWarp, FitRecoversASmoothWarpToAFractionOfAFrame) {
  const TimeWarp truth = TimeWarp::FromLogSlopes((Eigen::VectorXd(5) << 0.2, 0.1, -0.2, -0.1, 0.15).finished());
  const TimeWarp fine = TimeWarp::Fit(StairOf(truth, 400, 500), 400, 500, 5, 1e-9);
  EXPECT_LT((fine.log_slopes() - truth.log_slopes()).cwiseAbs().maxCoeff(), 0.01);
  const TimeWarp coarse = TimeWarp::Fit(StairOf(truth, 18, 20), 18, 20, 5, 1e-3);
  for (double p = 0; p <= 1; p += 0.01) EXPECT_NEAR(coarse(p), truth(p), 0.25 / 17) << p;
}

TEST(TimeWarp, FitEndsWhereItsObjectiveIsLeast) {
  std::mt19937_64 rng(5);
  const WarpPath path = DynamicTimeWarp(RandomCosts(18, 16, rng));
  const double regularisation = 1e-3;
  const auto objective = [&](const TimeWarp& warp, const Eigen::VectorXd& log_slopes) {
    double sum = 0;
    for (const WarpCell& cell : path.cells) sum += std::pow(warp(cell.reference / 17.0) - cell.test / 15.0, 2);
    const Eigen::VectorXd weights = (Eigen::VectorXd(5) << 0.125, 0.25, 0.25, 0.25, 0.125).finished();
    return sum / path.cells.size() + regularisation * (weights.array() * log_slopes.array().square()).sum();
  };
  const TimeWarp warp = TimeWarp::Fit(path, 18, 16, 5, regularisation);
  // Normalising shifts all log slopes alike; the fit's own constant is the one with zero weighted mean.
  const double mean = warp.log_slopes().dot((Eigen::VectorXd(5) << 0.125, 0.25, 0.25, 0.25, 0.125).finished());
  const Eigen::VectorXd fitted = warp.log_slopes().array() - mean;
  const double least = objective(warp, fitted);
  for (int k = 0; k < 5; ++k) {
    for (const double move : {-1e-3, 1e-3}) {
      const Eigen::VectorXd moved = fitted + move * Eigen::VectorXd::Unit(5, k);
      EXPECT_GT(objective(TimeWarp::FromLogSlopes(moved), moved), least) << k;
    }
  }
}

TEST(TimeWarp, FitKeepsStairStepsOut) {
  // Uniform time between 17 and 23 frames: the path is a stair, the fit must be a line.
  const WarpPath path = StairOf(TimeWarp(), 17, 23);
  const TimeWarp warp = TimeWarp::Fit(path, 17, 23, 6, 1e-3);
  // Not 0: the stair's end points are fixed and its first and last treads are half as wide as the others. Measured 0.081, at the ends.
  EXPECT_LT(warp.log_slopes().cwiseAbs().maxCoeff(), 0.085);
  const TimeWarp unregularised = TimeWarp::Fit(path, 17, 23, 6, 1e-9);
  EXPECT_GT(unregularised.log_slopes().cwiseAbs().maxCoeff(), 1.2 * warp.log_slopes().cwiseAbs().maxCoeff());
}

TEST(TimeWarp, FitRefusesBadInput) {
  const WarpPath path = StairOf(TimeWarp(), 5, 5);
  EXPECT_THROW(TimeWarp::Fit(path, 5, 5, 1, 1e-3), std::invalid_argument);
  EXPECT_THROW(TimeWarp::Fit(path, 5, 5, 4, 0), std::invalid_argument);
  EXPECT_THROW(TimeWarp::Fit(path, 4, 5, 4, 1e-3), std::invalid_argument);
  EXPECT_THROW(TimeWarp::Fit(path, 1, 5, 4, 1e-3), std::invalid_argument);
  EXPECT_THROW(TimeWarp::Fit(WarpPath{}, 5, 5, 4, 1e-3), std::invalid_argument);
}

TEST(TimeWarp, GradientAgreesWithCentralDifferences) {
  Eigen::VectorXd slopes(5);
  slopes << 0.2, -0.1, 0.4, 0.0, -0.3;
  constexpr double kStep = 1e-5;
  for (const double phase : {-0.2, 0.0, 0.1, 0.25, 0.7, 1.0, 1.2}) {
    const Eigen::VectorXd gradient = TimeWarp::FromLogSlopes(slopes).Gradient(phase);
    for (int d = 0; d < 5; ++d) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(5, d);
      const double difference = (TimeWarp::FromLogSlopes(slopes + step)(phase) - TimeWarp::FromLogSlopes(slopes - step)(phase)) / (2 * kStep);
      EXPECT_NEAR(gradient[d], difference, 1e-9) << "phase " << phase;
    }
  }
}

}  // namespace
}  // namespace morphograph
