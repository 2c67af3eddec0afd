#include "datasets/motion_clip.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <stdexcept>

#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {


std::shared_ptr<const Skeleton> OneJoint() {
  return std::make_shared<const Skeleton>(std::vector<Joint>{{"Root", -1, {0, 0, 0}, {}, {}}}, RoleMap(), 1, UpAxis::kY);
}

MotionClip ShortWalk() {
  SyntheticGaitOptions options;
  options.steps = 4;
  options.heading_rad = 0.3;
  options.style = "plain";
  return GenerateGait(options);
}

TEST(MotionClip, StartsAtTheOriginUnturned) {
  const MotionClip clip(OneJoint(), 25, 3);
  EXPECT_EQ(clip.frame_count(), 3);
  EXPECT_EQ(clip.joint_count(), 1);
  EXPECT_DOUBLE_EQ(clip.duration_s(), 2 / 25.0);
  for (int f = 0; f < 3; ++f) {
    EXPECT_EQ(clip.rotation(f, 0).coeffs(), Eigen::Quaterniond::Identity().coeffs());
    EXPECT_TRUE(clip.root_positions().col(f).isZero(0));
  }
  EXPECT_EQ(MotionClip(OneJoint(), 25, 1).duration_s(), 0);
  EXPECT_EQ(MotionClip(OneJoint(), 25, 0).duration_s(), 0);
}

TEST(MotionClip, RefusesWhatIsNoClip) {
  EXPECT_THROW(MotionClip(nullptr, 30, 3), std::invalid_argument);
  EXPECT_THROW(MotionClip(OneJoint(), 30, -1), std::invalid_argument);
  for (const double rate : {0.0, -30.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(MotionClip(OneJoint(), rate, 3), std::invalid_argument) << rate;
}

TEST(MotionClip, ASliceHoldsItsFramesAndNames) {
  MotionClip clip = ShortWalk();
  clip.name = "walk_01";
  const MotionClip slice = clip.Slice(10, 20);
  ASSERT_EQ(slice.frame_count(), 20);
  EXPECT_EQ(slice.frame_rate_hz(), clip.frame_rate_hz());
  EXPECT_EQ(slice.shared_skeleton(), clip.shared_skeleton());
  EXPECT_EQ(slice.name, "walk_01");
  EXPECT_EQ(slice.style, "plain");
  for (int f = 0; f < 20; ++f) {
    EXPECT_EQ(slice.root_positions().col(f), clip.root_positions().col(10 + f));
    for (int j = 0; j < clip.joint_count(); ++j)
      EXPECT_EQ(slice.rotation(f, j).coeffs(), clip.rotation(10 + f, j).coeffs());
  }
  EXPECT_EQ(clip.Slice(clip.frame_count(), 0).frame_count(), 0);
}

TEST(MotionClip, ASliceStaysInsideTheClip) {
  const MotionClip clip(OneJoint(), 30, 5);
  constexpr int kMost = std::numeric_limits<int>::max();
  for (const auto& [first, count] : {std::pair{-1, 2}, {0, -1}, {0, 6}, {5, 1}, {6, 0}, {1, kMost}, {kMost, kMost}, {kMost, 1}})
    EXPECT_THROW(clip.Slice(first, count), std::invalid_argument) << first << " " << count;
}

TEST(MotionClip, MovingTurnsTheWholeBodyAboutTheWorldsOrigin) {
  const MotionClip clip = ShortWalk();
  const double yaw = 2.1;
  const MotionClip moved = Moved(clip, yaw, 3, -4);
  // Seen from above, +Z turned by +90 degrees is +X.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR((Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()) * Eigen::Vector3d::UnitZ()).x(), 1, 1e-15);
  for (int f = 0; f < clip.frame_count(); f += 7) {
    const WorldPose before = ForwardKinematics(clip, f), after = ForwardKinematics(moved, f);
    const Eigen::Matrix3Xd expected = (turn * before.positions).colwise() + Eigen::Vector3d(3, 0, -4);
    EXPECT_LT((after.positions - expected).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(std::remainder(HeadingRad(moved, f) - HeadingRad(clip, f) - yaw, 2 * std::numbers::pi), 0, 1e-12);
  }
}

TEST(MotionClip, HeadingIsWhereTheHipsFace) {
  SyntheticGaitOptions options;
  options.steps = 6;
  for (const double heading : {0.0, std::numbers::pi / 2, -2.5}) {
    options.heading_rad = heading;
    const MotionClip clip = GenerateGait(options);
    EXPECT_NEAR(std::remainder(HeadingRad(clip, 0) - heading, 2 * std::numbers::pi), 0, 1e-6);  // standing
    const int middle = clip.frame_count() / 2;
    EXPECT_NEAR(std::remainder(HeadingRad(clip, middle) - heading, 2 * std::numbers::pi), 0, 0.2);  // the pelvis turns with each step
  }
}

TEST(MotionClip, WithoutHipsTheHeadingIsTheRootsOwn) {
  MotionClip clip(OneJoint(), 30, 1);
  EXPECT_EQ(HeadingRad(clip, 0), 0);
  clip.rotation(0, 0) = Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitY());
  EXPECT_NEAR(HeadingRad(clip, 0), 1.2, 1e-15);
}

}  // namespace
}  // namespace morphograph
