#include "synthesis/foot_lock.h"

#include <gtest/gtest.h>

#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

struct FootPoints {
  Eigen::Matrix3Xd heels, balls;
};

FootPoints PointsOf(const MotionClip& clip, const FeetGeometry& feet, int side) {
  const RoleMap& roles = clip.skeleton().roles();
  const int ankle = roles[side == 0 ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
  const int toe = roles[side == 0 ? JointRole::kLeftToe : JointRole::kRightToe];
  FootPoints points{Eigen::Matrix3Xd(3, clip.frame_count()), Eigen::Matrix3Xd(3, clip.frame_count())};
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(clip, f);
    points.heels.col(f) = pose.positions.col(ankle) + pose.rotations[ankle] * feet.heel_offset_m[side];
    points.balls.col(f) = pose.positions.col(toe);
  }
  return points;
}

class FootLockTest : public ::testing::Test {
 protected:
  FootLockTest() : model_(testing::SmallModel()), feet_(model_->styles().front().feet) {
    auto walks = testing::SmallWalks();
    clip_ = std::make_unique<MotionClip>(std::move(walks.front().second));
    contacts_ = DetectContacts(*clip_).planted.cast<double>().matrix();
  }
  std::shared_ptr<const MotionGraph> model_;
  FeetGeometry feet_;
  std::unique_ptr<MotionClip> clip_;
  Eigen::Matrix4Xd contacts_;
};

TEST_F(FootLockTest, LearnsHowLowFeetCome) {
  for (int side = 0; side < 2; ++side) {
    EXPECT_LE(feet_.heel_lowest_m[side], feet_.heel_height_m[side]);
    EXPECT_LE(feet_.ball_lowest_m[side], feet_.ball_height_m[side]);
    EXPECT_GE(feet_.ball_lowest_m[side], feet_.ball_height_m[side] - 0.0091);
  }
}

TEST_F(FootLockTest, LiftsFeetThatComeLowerThanCapturedOnes) {
  clip_->root_positions().row(1).array() -= 0.03;
  ASSERT_LT(PointsOf(*clip_, feet_, 0).balls.row(1).minCoeff(), feet_.ball_lowest_m[0] - 0.01);
  LockFeet(feet_, contacts_, {}, clip_.get());
  for (int side = 0; side < 2; ++side) {
    const FootPoints points = PointsOf(*clip_, feet_, side);
    // Corners of the correction are rounded, so that a foot may pass the limit by some millimetres for a frame.
    EXPECT_GT(points.balls.row(1).minCoeff(), feet_.ball_lowest_m[side] - 0.006) << side;
    EXPECT_GT(points.heels.row(1).minCoeff(), feet_.heel_lowest_m[side] - 0.006) << side;
  }
}

TEST_F(FootLockTest, HoldsPlantedBallsOnTheirSpot) {
  // The root slides sideways under the feet, 10 cm/s.
  for (int f = 0; f < clip_->frame_count(); ++f) clip_->root_positions()(0, f) += 0.1 * f / clip_->frame_rate_hz();
  LockFeet(feet_, contacts_, {}, clip_.get());
  double worst = 0;
  for (int side = 0; side < 2; ++side) {
    const FootPoints points = PointsOf(*clip_, feet_, side);
    for (int f = 2; f + 3 < clip_->frame_count(); ++f) {
      // The middle of stances: all around is planted.
      if (contacts_.row(2 * side + 1).segment(f - 2, 6).minCoeff() < 1) continue;
      const Eigen::Vector3d step = points.balls.col(f + 1) - points.balls.col(f);
      worst = std::max(worst, std::hypot(step.x(), step.z()) * clip_->frame_rate_hz());
    }
  }
  EXPECT_GT(worst, 0);
  EXPECT_LT(worst, 0.02);  // of the 0.1 m/s
}

TEST_F(FootLockTest, LeavesHeadAndArmsAlone) {
  const MotionClip before = *clip_;
  clip_->root_positions().row(1).array() -= 0.01;
  LockFeet(feet_, contacts_, {}, clip_.get());
  const RoleMap& roles = clip_->skeleton().roles();
  for (const JointRole role : {JointRole::kHead, JointRole::kLeftWrist, JointRole::kHips}) {
    for (int f = 0; f < clip_->frame_count(); ++f) {
      ASSERT_EQ(clip_->rotation(f, roles[role]).coeffs(), before.rotation(f, roles[role]).coeffs());
    }
  }
}

}  // namespace
}  // namespace morphograph
