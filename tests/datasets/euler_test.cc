#include "datasets/euler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

constexpr double kPi = std::numbers::pi;

const std::vector<EulerOrder>& AllOrders() {
  static const std::vector<EulerOrder> orders = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  return orders;
}

std::string Name(const EulerOrder& order) {
  std::string name;
  for (const int axis : order) name += "XYZ"[axis];
  return name;
}

// A turn about one axis as textbooks print it.
Eigen::Matrix3d AxisTurn(int axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Eigen::Matrix3d m;
  if (axis == 0) {
    m << 1, 0, 0, 0, c, -s, 0, s, c;
  } else if (axis == 1) {
    m << c, 0, s, 0, 1, 0, -s, 0, c;
  } else {
    m << c, -s, 0, s, c, 0, 0, 0, 1;
  }
  return m;
}

Eigen::Matrix3d Turned(const Eigen::Vector3d& angles, const EulerOrder& order) {
  return AxisTurn(order[0], angles[0]) * AxisTurn(order[1], angles[1]) * AxisTurn(order[2], angles[2]);
}

Eigen::Vector3d RandomAngles(double most, std::mt19937_64& rng) {
  return {testing::RandomUniform(-most, most, rng), testing::RandomUniform(-most, most, rng),
          testing::RandomUniform(-most, most, rng)};
}

// The least distance of any triple for the same rotation: both branches, any number of whole turns.
double LeastDistance(const Eigen::Vector3d& angles, const Eigen::Vector3d& previous) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& branch : {angles, Eigen::Vector3d(angles[0] + kPi, kPi - angles[1], angles[2] + kPi)}) {
    Eigen::Vector3d gap;
    for (int i = 0; i < 3; ++i) gap[i] = std::remainder(branch[i] - previous[i], 2 * kPi);
    least = std::min(least, gap.norm());
  }
  return least;
}

TEST(Euler, AnglesTurnAboutTheirAxesInTheirOrder) {
  std::mt19937_64 rng(1);
  for (const EulerOrder& order : AllOrders()) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d angles = RandomAngles(10, rng);
      const Eigen::Quaterniond q = QuaternionFromEuler(angles, order);
      EXPECT_NEAR(q.norm(), 1, 1e-14);
      EXPECT_LT((q.toRotationMatrix() - Turned(angles, order)).norm(), 1e-13) << Name(order);
    }
  }
}

TEST(Euler, EveryRotationComesBackAsTheNearestTriple) {
  std::mt19937_64 rng(2);
  for (const EulerOrder& order : AllOrders()) {
    for (int i = 0; i < 500; ++i) {
      const Eigen::Quaterniond rotation = testing::RandomRotation(rng);
      const Eigen::Vector3d previous = RandomAngles(15, rng);
      const Eigen::Vector3d angles = EulerNear(rotation, order, previous);
      EXPECT_LT((Turned(angles, order) - rotation.toRotationMatrix()).norm(), 1e-12) << Name(order);
      EXPECT_NEAR((angles - previous).norm(), LeastDistance(angles, previous), 1e-9) << Name(order);
    }
  }
}

TEST(Euler, AtGimbalLockTheThirdAngleStaysAndTheRotationIsRight) {
  std::mt19937_64 rng(3);
  for (const EulerOrder& order : AllOrders()) {
    for (const double middle : {kPi / 2, -kPi / 2}) {
      for (int i = 0; i < 50; ++i) {
        const Eigen::Vector3d previous = RandomAngles(7, rng);
        const Eigen::Vector3d exact(testing::RandomUniform(-3, 3, rng), middle, testing::RandomUniform(-3, 3, rng));
        const Eigen::Vector3d angles = EulerNear(QuaternionFromEuler(exact, order), order, previous);
        EXPECT_LT((Turned(angles, order) - Turned(exact, order)).norm(), 1e-7) << Name(order) << " " << middle;
        EXPECT_EQ(angles[2], previous[2]) << Name(order) << " " << middle;
        EXPECT_LE(std::abs(angles[0] - previous[0]), kPi + 1e-9);
      }
    }
  }
}

TEST(Euler, JustBesideGimbalLockNothingIsLost) {
  std::mt19937_64 rng(4);
  for (const EulerOrder& order : AllOrders()) {
    for (const double beside : {1e-3, 1e-5, 1e-6, 1e-8, 1e-12}) {
      const Eigen::Vector3d exact(testing::RandomUniform(-3, 3, rng), kPi / 2 - beside, testing::RandomUniform(-3, 3, rng));
      const Eigen::Vector3d angles = EulerNear(QuaternionFromEuler(exact, order), order, RandomAngles(3, rng));
      EXPECT_LT((Turned(angles, order) - Turned(exact, order)).norm(), 2e-7) << Name(order) << " " << beside;
    }
  }
}

// A joint that spins on and on, with the middle angle swinging through both locks: no angle may jump.
TEST(Euler, TracksRunOnThroughWholeTurnsAndThroughTheLock) {
  constexpr int kSteps = 2000;
  for (const EulerOrder& order : AllOrders()) {
    Eigen::Vector3d angles(0.1, 0.2, 0.3), written = angles;
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      written = {0.1 + 14 * t, 0.2 + 10 * t, 0.3 - 12 * t};  // passes 90 degrees plus whole half turns several times
      angles = EulerNear(QuaternionFromEuler(written, order), order, angles);
      ASSERT_LT((angles - written).norm(), 1e-6) << Name(order) << " at " << i;
    }
  }
}

}  // namespace
}  // namespace morphograph
