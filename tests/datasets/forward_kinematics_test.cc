#include "datasets/forward_kinematics.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "datasets/synthetic_gait.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

Eigen::Quaterniond QuarterTurn(const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, axis));
}

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(), kZ = Eigen::Vector3d::UnitZ();

void ExpectNear(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected) {
  EXPECT_LT((actual - expected).norm(), 1e-14) << actual.transpose() << ", expected " << expected.transpose();
}

// Worked out by hand: turns by 90 degrees carry axes to axes.
TEST(ForwardKinematics, AChainOfQuarterTurnsIsWhereItMustBe) {
  const auto skeleton = std::make_shared<const Skeleton>(
      std::vector<Joint>{{"a", -1, {9, 9, 9}, {}, {}},   // a root's own offset is replaced by its position
                         {"b", 0, {0, 1, 0}, {}, {}},
                         {"c", 1, {0, 0, 2}, {}, {}},
                         {"d", 2, {3, 0, 0}, {}, {}},
                         {"e", 0, {0, 0, 5}, {}, {}}},
      RoleMap(), 1, UpAxis::kY);
  MotionClip clip(skeleton, 30, 1);
  clip.root_positions().col(0) = Eigen::Vector3d(1, 2, 3);
  clip.rotation(0, 0) = QuarterTurn(kZ);  // x -> y, y -> -x
  clip.rotation(0, 1) = QuarterTurn(kX);  // y -> z, z -> -y
  clip.rotation(0, 2) = QuarterTurn(kY);  // z -> x, x -> -z
  const WorldPose pose = ForwardKinematics(clip, 0);
  ExpectNear(pose.positions.col(0), {1, 2, 3});
  ExpectNear(pose.positions.col(1), {0, 2, 3});   // + Rz (0,1,0) = (-1,0,0)
  ExpectNear(pose.positions.col(2), {2, 2, 3});   // + Rz Rx (0,0,2) = Rz (0,-2,0) = (2,0,0)
  ExpectNear(pose.positions.col(3), {-1, 2, 3});  // + Rz Rx Ry (3,0,0) = Rz Rx (0,0,-3) = Rz (0,3,0) = (-3,0,0)
  ExpectNear(pose.positions.col(4), {1, 2, 8});   // a sibling branch: + Rz (0,0,5)
  ExpectNear(pose.rotations[2] * kX, QuarterTurn(kZ) * (QuarterTurn(kX) * (QuarterTurn(kY) * kX)));
  ExpectNear(pose.rotations[4] * kX, kY);
}

TEST(ForwardKinematics, JointsAboveTheMovingRootStandAtTheOrigin) {
  RoleMap roles;
  roles.Set(JointRole::kHips, 1);
  const auto skeleton = std::make_shared<const Skeleton>(
      std::vector<Joint>{{"root", -1, {0, 0, 0}, {}, {}}, {"hips", 0, {0, 0, 0}, {}, {}}, {"spine", 1, {0, 0.2, 0}, {}, {}},
                         {"prop", 0, {0.5, 0, 0}, {}, {}}},
      roles, 1, UpAxis::kY);
  MotionClip clip(skeleton, 30, 1);
  clip.root_positions().col(0) = Eigen::Vector3d(4, 1, -2);
  clip.rotation(0, 1) = QuarterTurn(kX);
  const WorldPose pose = ForwardKinematics(clip, 0);
  ExpectNear(pose.positions.col(0), {0, 0, 0});
  ExpectNear(pose.positions.col(1), {4, 1, -2});
  ExpectNear(pose.positions.col(2), {4, 1, -1.8});
  ExpectNear(pose.positions.col(3), {0.5, 0, 0});
}

TEST(ForwardKinematics, KeepsBoneLengthsWhateverTheRotations) {
  std::mt19937_64 rng(5);
  SyntheticGaitOptions options;
  options.steps = 2;
  MotionClip clip = GenerateGait(options);
  for (int f = 0; f < 10; ++f) {
    for (int j = 0; j < clip.joint_count(); ++j) clip.rotation(f, j) = testing::RandomRotation(rng);
    const WorldPose pose = ForwardKinematics(clip, f);
    for (int j = 1; j < clip.joint_count(); ++j) {
      const int parent = clip.skeleton().parent(j);
      EXPECT_NEAR((pose.positions.col(j) - pose.positions.col(parent)).norm(), clip.skeleton().joint(j).offset_m.norm(), 1e-12);
    }
  }
}

TEST(ForwardKinematics, PositionsOfAClipAreThoseOfItsFrames) {
  SyntheticGaitOptions options;
  options.steps = 2;
  const MotionClip clip = GenerateGait(options);
  const std::vector<Eigen::Matrix3Xd> all = JointPositions(clip);
  ASSERT_EQ(static_cast<int>(all.size()), clip.frame_count());
  for (int f = 0; f < clip.frame_count(); f += 11) EXPECT_EQ(all[static_cast<size_t>(f)], ForwardKinematics(clip, f).positions);
}

TEST(ForwardKinematics, APoseOfAnotherSkeletonIsResized) {
  const Skeleton one({{"a", -1, {0, 0, 0}, {}, {}}}, RoleMap(), 1, UpAxis::kY);
  const Skeleton two({{"a", -1, {0, 0, 0}, {}, {}}, {"b", 0, {0, 1, 0}, {}, {}}}, RoleMap(), 1, UpAxis::kY);
  const std::vector<Eigen::Quaterniond> still(2, Eigen::Quaterniond::Identity());
  WorldPose pose;
  ForwardKinematics(two, still.data(), {0, 0, 0}, &pose);
  EXPECT_EQ(pose.positions.cols(), 2);
  ForwardKinematics(one, still.data(), {1, 0, 0}, &pose);
  ASSERT_EQ(pose.positions.cols(), 1);
  EXPECT_EQ(pose.rotations.size(), 1u);
  ExpectNear(pose.positions.col(0), {1, 0, 0});
}

}  // namespace
}  // namespace morphograph
