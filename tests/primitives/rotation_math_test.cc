#include "primitives/rotation_math.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;
using testing::RandomRotation;
using testing::RandomUniform;

constexpr double kPi = std::numbers::pi;

TEST(RotationMath, ExpMapAgreesWithAngleAxisAtEveryAngle) {
  std::mt19937_64 rng(1);
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.3, 1.0, 2.0, 3.0, kPi, 3.16, 3.17, 4.5, 6.2, 9.0}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Eigen::Vector3d axis = Eigen::Vector3d(RandomNormal(3, 1, rng)).normalized();
      const Eigen::Quaterniond expected(Eigen::AngleAxisd(angle, axis));
      const Eigen::Quaterniond q = ExpMap(angle * axis);
      EXPECT_LT((q.coeffs() - expected.coeffs()).cwiseAbs().maxCoeff(), 1e-15) << angle;
    }
  }
}

TEST(RotationMath, ExpMapKeepsSmallVectorsToFullRelativePrecision) {
  const Eigen::Vector3d tiny(1e-9, -2e-9, 3e-9);
  EXPECT_LT((2 * ExpMap(tiny).vec() - tiny).norm(), 1e-16 * tiny.norm() * 10);
  EXPECT_LT((LogMap(ExpMap(tiny)) - tiny).norm(), 1e-15 * tiny.norm());
}

TEST(RotationMath, RightJacobianTellsHowTheExponentialMapTurns) {
  for (const double angle : {0.0, 1e-4, 0.3, 2.0, 3.0}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(0.6, -0.48, 0.64);
    const Eigen::Matrix3d jacobian = RightJacobian(v);
    constexpr double kStep = 1e-5;
    for (int d = 0; d < 3; ++d) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(d);
      const Eigen::Vector3d turn = LogMap(ExpMap(v - step).conjugate() * ExpMap(v + step)) / (2 * kStep);
      EXPECT_LT((turn - jacobian.col(d)).norm(), 1e-7) << "angle " << angle;
    }
  }
}

TEST(RotationMath, LogMapInvertsExpMapUpToAHalfTurn) {
  std::mt19937_64 rng(2);
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-5, 1e-3, 0.3, 1.0, 2.0, 3.0, kPi - 1e-6}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(RandomNormal(3, 1, rng)).normalized();
    EXPECT_LT((LogMap(ExpMap(v)) - v).norm(), 1e-14 * (1 + angle)) << angle;
  }
}

TEST(RotationMath, LogMapIsTheShortestAndIgnoresTheSignOfTheQuaternion) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Quaterniond q = RandomRotation(rng);
    const Eigen::Quaterniond negative(-q.w(), -q.x(), -q.y(), -q.z());
    EXPECT_LE(LogMap(q).norm(), kPi + 1e-12);
    EXPECT_LT((LogMap(q) - LogMap(negative)).norm(), 1e-15);
    EXPECT_NEAR(std::abs(ExpMap(LogMap(q)).dot(q)), 1.0, 1e-14);
  }
}

TEST(RotationMath, MapsAboutAMeanInvertEachOther) {
  std::mt19937_64 rng(4);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Quaterniond mean = RandomRotation(rng), q = RandomRotation(rng);
    EXPECT_LT(q.angularDistance(ExpMapAbout(mean, LogMapAbout(mean, q))), 1e-7);  // angularDistance itself is no better
  }
}

TEST(RotationMath, GeodesicMeanHasZeroMeanLogWhateverTheSignsOfTheQuaternions) {
  std::mt19937_64 rng(5);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const Eigen::Quaterniond centre = RandomRotation(rng);
    std::vector<Eigen::Quaterniond> rotations;
    for (int i = 0; i < 30; ++i) {
      rotations.push_back(ExpMapAbout(centre, 0.5 * RandomNormal(3, 1, rng)));
      if (RandomUniform(0, 1, rng) < 0.5) rotations.back().coeffs() *= -1;
    }
    const Eigen::Quaterniond mean = GeodesicMean(rotations);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double cost = 0;
    for (const Eigen::Quaterniond& q : rotations) {
      sum += LogMapAbout(mean, q);
      cost += LogMapAbout(mean, q).squaredNorm();
    }
    EXPECT_LT(sum.norm(), 1e-11);
    EXPECT_GE(mean.w(), 0);
    for (int direction = 0; direction < 3; ++direction) {  // and it is a minimum
      const Eigen::Quaterniond moved = ExpMapAbout(mean, 0.01 * Eigen::Vector3d::Unit(direction));
      double moved_cost = 0;
      for (const Eigen::Quaterniond& q : rotations) moved_cost += LogMapAbout(moved, q).squaredNorm();
      EXPECT_GT(moved_cost, cost);
    }
  }
}

TEST(RotationMath, GeodesicMeanOfTwoIsHalfWay) {
  const Eigen::Quaterniond a(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond b(Eigen::AngleAxisd(1.4, Eigen::Vector3d::UnitY()));
  EXPECT_LT((LogMap(GeodesicMean({a, b})) - Eigen::Vector3d(0, 0.8, 0)).norm(), 1e-13);
  EXPECT_LT((LogMap(GeodesicMean({b})) - Eigen::Vector3d(0, 1.4, 0)).norm(), 1e-13);
  EXPECT_THROW(GeodesicMean({}), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
