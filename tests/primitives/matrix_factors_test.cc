#include "primitives/matrix_factors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;

// Orthonormal columns by Gram and Schmidt, twice, since once leaves what rounding mixed in.
Eigen::MatrixXd RandomAxes(Eigen::Index rows, Eigen::Index columns, std::mt19937_64& rng) {
  Eigen::MatrixXd axes = RandomNormal(rows, columns, rng);
  for (int pass = 0; pass < 2; ++pass) {
    for (Eigen::Index c = 0; c < columns; ++c) {
      for (Eigen::Index b = 0; b < c; ++b) axes.col(c) -= axes.col(b).dot(axes.col(c)) * axes.col(b);
      axes.col(c).normalize();
    }
  }
  return axes;
}

double WorstFromIdentity(const Eigen::MatrixXd& gram) {
  return (gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff();
}

TEST(MatrixFactors, SymmetricOnesAreFoundAgain) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd axes = RandomAxes(20, 20, rng);
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(20, -3, 7);
  const Eigen::MatrixXd matrix = axes * values.asDiagonal() * axes.transpose();
  const SymmetricFactors factors = FactorSymmetric(matrix);
  EXPECT_LT((factors.values - values).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT(WorstFromIdentity(factors.vectors.transpose() * factors.vectors), 1e-13);
  EXPECT_LT((factors.vectors * factors.values.asDiagonal() * factors.vectors.transpose() - matrix).norm(), 1e-12);
}

TEST(MatrixFactors, SingularValuesAndAxesAreFoundAgain) {
  std::mt19937_64 rng(2);
  for (const auto& [rows, columns] : {std::pair{30, 30}, {80, 12}, {12, 80}, {5, 1}, {1, 5}, {1, 1}}) {
    const Eigen::Index n = std::min(rows, columns);
    Eigen::VectorXd values(n);
    for (Eigen::Index i = 0; i < n; ++i) values[i] = std::pow(0.5, static_cast<double>(i));
    const Eigen::MatrixXd u = RandomAxes(rows, n, rng), v = RandomAxes(columns, n, rng);
    const SingularFactors found = FactorSingular(u * values.asDiagonal() * v.transpose());
    ASSERT_EQ(found.u.cols(), n) << rows << " x " << columns;
    EXPECT_LT((found.values - values).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT(WorstFromIdentity(found.u.transpose() * found.u), 1e-13);
    EXPECT_LT(WorstFromIdentity(found.v.transpose() * found.v), 1e-13);
    EXPECT_LT((found.u * found.values.asDiagonal() * found.v.transpose() - u * values.asDiagonal() * v.transpose()).norm(),
              1e-14 * static_cast<double>(rows + columns));
  }
}

// The Gram matrix alone would give 1e-8 for the smallest, and no axis.
TEST(MatrixFactors, SmallSingularValuesAreNotLost) {
  std::mt19937_64 rng(3);
  const Eigen::VectorXd values = (Eigen::VectorXd(4) << 1, 1e-5, 1e-9, 1e-12).finished();
  const Eigen::MatrixXd u = RandomAxes(40, 4, rng), v = RandomAxes(4, 4, rng);
  const SingularFactors found = FactorSingular(u * values.asDiagonal() * v.transpose());
  ASSERT_EQ(found.u.cols(), 4);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(found.values[i], values[i], 2e-15);
  EXPECT_LT(WorstFromIdentity(found.u.transpose() * found.u), 1e-13);
  EXPECT_NEAR(std::abs(found.u.col(2).dot(u.col(2))), 1, 1e-5);
}

TEST(MatrixFactors, NoMoreAxesThanTheRankAndThanAskedFor) {
  std::mt19937_64 rng(4);
  const Eigen::MatrixXd low = RandomNormal(50, 3, rng) * RandomNormal(3, 20, rng);
  const SingularFactors all = FactorSingular(low);
  EXPECT_EQ(all.u.cols(), 3);
  EXPECT_EQ(all.v.cols(), 3);
  ASSERT_EQ(all.values.size(), 20);
  EXPECT_LT(all.values[3], 1e-13 * all.values[0]);
  const SingularFactors two = FactorSingular(low, [](const Eigen::VectorXd& values) { return values[1] > 0 ? 2 : 0; });
  EXPECT_EQ(two.u, all.u.leftCols(2));
  EXPECT_EQ(two.v, all.v.leftCols(2));
  EXPECT_EQ(FactorSingular(Eigen::MatrixXd::Zero(6, 4)).u.cols(), 0);
  EXPECT_EQ(FactorSingular(Eigen::MatrixXd(6, 0)).values.size(), 0);
  EXPECT_EQ(FactorSingular(Eigen::MatrixXd(0, 6)).values.size(), 0);
}

TEST(MatrixFactors, WhatIsNotFiniteIsAnError) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(4, 4);
  matrix(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(FactorSymmetric(matrix), std::runtime_error);
  EXPECT_THROW(FactorSingular(matrix), std::runtime_error);
}

}  // namespace
}  // namespace morphograph
