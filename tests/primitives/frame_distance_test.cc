#include "primitives/frame_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;
using testing::RandomUniform;

Eigen::Matrix3Xd Moved(const Eigen::Matrix3Xd& pose, const PlanarTransform& transform) {
  Eigen::Matrix3Xd out(3, pose.cols());
  for (Eigen::Index i = 0; i < pose.cols(); ++i) out.col(i) = transform * Eigen::Vector3d(pose.col(i));
  return out;
}

double WeightedSquares(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, const Eigen::VectorXd& weights) {
  return ((a - b).colwise().squaredNorm() * weights).value();
}

Eigen::VectorXd RandomWeights(int joints, std::mt19937_64& rng) {
  Eigen::VectorXd weights(joints);
  for (double& w : weights) w = RandomUniform(0.05, 1, rng);
  return weights / weights.sum();
}

TEST(PlanarTransform, YawTurnsForwardTowardsPlusX) {
  const PlanarTransform quarter{std::numbers::pi / 2, 1, 2};
  EXPECT_LT((quarter * Eigen::Vector3d(0, 5, 1) - Eigen::Vector3d(2, 5, 2)).norm(), 1e-15);
}

TEST(FrameDistance, ClosedFormEqualsANumericMinimumInEveryQuadrant) {
  std::mt19937_64 rng(1);
  for (int repeat = 0; repeat < 40; ++repeat) {
    const Eigen::Matrix3Xd a = RandomNormal(3, 12, rng);
    const PlanarTransform moved{-3.1 + 0.16 * repeat, RandomUniform(-3, 3, rng), RandomUniform(-3, 3, rng)};
    const Eigen::Matrix3Xd b = Moved(a, moved) + 0.3 * RandomNormal(3, 12, rng);
    const Eigen::VectorXd weights = RandomWeights(12, rng);
    // For a given yaw the best move is the difference of weighted means; the yaw is searched over the whole circle, then finer.
    const auto cost = [&](double yaw) {
      const Eigen::Matrix3Xd turned = Moved(b, {yaw, 0, 0});
      const Eigen::Vector3d shift = (a - turned) * weights / weights.sum();
      return WeightedSquares(a, Moved(turned, {0, shift.x(), shift.z()}), weights);
    };
    double best_yaw = 0, best = std::numeric_limits<double>::infinity();
    for (double centre = 0, width = std::numbers::pi; width > 1e-9; width /= 10) {
      for (int i = -40; i <= 40; ++i) {
        const double yaw = centre + width * i / 40;
        if (const double c = cost(yaw); c < best) best = c, best_yaw = yaw;
      }
      centre = best_yaw;
    }
    PlanarTransform found;
    const double distance = FrameDistance(a, b, weights, &found);
    EXPECT_NEAR(distance, best, 1e-9 * (1 + best));
    EXPECT_NEAR(std::remainder(found.yaw_rad - best_yaw, 2 * std::numbers::pi), 0, 1e-6);
    EXPECT_NEAR(WeightedSquares(a, Moved(b, found), weights), distance, 1e-12);
  }
}

TEST(FrameDistance, IgnoresHeadingAndFloorPositionButNotHeight) {
  std::mt19937_64 rng(7);
  const Eigen::Matrix3Xd a = RandomNormal(3, 20, rng);
  const Eigen::VectorXd weights = RandomWeights(20, rng);
  const PlanarTransform transform{1.2, 3, -2};
  PlanarTransform found;
  EXPECT_NEAR(FrameDistance(Moved(a, transform), a, weights, &found), 0.0, 1e-12);
  EXPECT_NEAR(found.yaw_rad, 1.2, 1e-9);
  EXPECT_NEAR(found.x_m, 3, 1e-9);
  EXPECT_NEAR(found.z_m, -2, 1e-9);
  Eigen::Matrix3Xd higher = a;
  higher.row(1).array() += 0.5;
  EXPECT_NEAR(FrameDistance(higher, a, weights), 0.25, 1e-12);
}

TEST(FrameDistance, IsSymmetricAndMatchesTheMatrixForm) {
  std::mt19937_64 rng(8);
  std::vector<Eigen::Matrix3Xd> a, b;
  for (int i = 0; i < 5; ++i) a.push_back(RandomNormal(3, 9, rng));
  for (int i = 0; i < 7; ++i) b.push_back(RandomNormal(3, 9, rng).array() + 4.0);
  const Eigen::VectorXd weights = 3.0 * RandomWeights(9, rng);
  const Eigen::MatrixXd matrix = FrameDistanceMatrix(a, b, weights);
  ASSERT_EQ(matrix.rows(), 5);
  ASSERT_EQ(matrix.cols(), 7);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 7; ++j) {
      EXPECT_NEAR(FrameDistance(a[i], b[j], weights), FrameDistance(b[j], a[i], weights), 1e-12);
      EXPECT_NEAR(matrix(i, j), FrameDistance(a[i], b[j], weights), 1e-11);
    }
  }
}

TEST(FrameDistance, OfPointsOnOneVerticalLineIsDefined) {
  Eigen::Matrix3Xd a = Eigen::Matrix3Xd::Zero(3, 4), b = a;
  b.row(0).setConstant(2);
  EXPECT_NEAR(FrameDistance(a, b, Eigen::VectorXd::Ones(4)), 0, 1e-15);
}

TEST(FrameDistance, RefusesSizesAndWeightsThatDoNotFit) {
  const Eigen::Matrix3Xd a = Eigen::Matrix3Xd::Zero(3, 4), b = Eigen::Matrix3Xd::Zero(3, 5);
  EXPECT_THROW(FrameDistance(a, b, Eigen::VectorXd::Ones(4)), std::invalid_argument);
  EXPECT_THROW(FrameDistance(a, a, Eigen::VectorXd::Ones(5)), std::invalid_argument);
  EXPECT_THROW(FrameDistance(a, a, Eigen::VectorXd::Zero(4)), std::invalid_argument);
  EXPECT_THROW(FrameDistance(a, a, Eigen::Vector4d(1, 1, -0.1, 1)), std::invalid_argument);
  EXPECT_THROW(FrameDistanceMatrix({a}, {b}, Eigen::VectorXd::Ones(4)), std::invalid_argument);
}

TEST(FrameDistanceWeights, FallWithDepthAndSkipWhatIsNotABone) {
  const auto joint = [](const char* name, int parent, double length) {
    Joint out;
    out.name = name;
    out.parent = parent;
    out.offset_m = Eigen::Vector3d(0, length, 0);
    return out;
  };
  const std::vector<Joint> joints = {joint("World", -1, 0), joint("Hips", 0, 0.9), joint("LHipJoint", 1, 0),
                                     joint("LeftUpLeg", 2, 0.1), joint("LeftLeg", 3, 0.4), joint("Spine", 1, 0.1)};
  std::vector<std::string> names;
  for (const Joint& j : joints) names.push_back(j.name);
  const Skeleton skeleton(joints, DetectRoles(names), 1.0, UpAxis::kY);
  ASSERT_EQ(skeleton.moving_root(), 1);
  const Eigen::VectorXd weights = FrameDistanceWeights(skeleton);
  EXPECT_NEAR(weights.sum(), 1, 1e-15);
  EXPECT_EQ(weights[0], 0);
  EXPECT_EQ(weights[2], 0);
  EXPECT_NEAR(weights[3] / weights[1], 1.0 / 2, 1e-12);
  EXPECT_NEAR(weights[4] / weights[1], 1.0 / 3, 1e-12);
  EXPECT_NEAR(weights[5] / weights[1], 1.0 / 2, 1e-12);
}

}  // namespace
}  // namespace morphograph
