#include "synthesis/toe_bend.h"

#include <gtest/gtest.h>

#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

// A walk on a skeleton whose toes have such tips.
MotionClip WalkWithTips(const std::optional<Eigen::Vector3d>& tip_m) {
  const MotionClip walk = GenerateGait({});
  std::vector<Joint> joints = walk.skeleton().joints();
  for (const JointRole role : {JointRole::kLeftToe, JointRole::kRightToe}) {
    joints[walk.skeleton().roles()[role]].end_site_m = tip_m;
  }
  const auto skeleton = std::make_shared<const Skeleton>(joints, walk.skeleton().roles(), walk.skeleton().metres_per_unit(),
                                                         walk.skeleton().up_axis());
  MotionClip clip(skeleton, walk.frame_rate_hz(), walk.frame_count());
  clip.root_positions() = walk.root_positions();
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < clip.joint_count(); ++j) clip.rotation(f, j) = walk.rotation(f, j);
  }
  return clip;
}

double LowestTip(const MotionClip& clip) {
  double lowest = 1;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(clip, f);
    for (const JointRole role : {JointRole::kLeftToe, JointRole::kRightToe}) {
      const int toe = clip.skeleton().roles()[role];
      lowest = std::min(lowest, (pose.positions.col(toe) + pose.rotations[toe] * *clip.skeleton().joint(toe).end_site_m).y());
    }
  }
  return lowest;
}

TEST(BendToes, KeepsTipsFromGoingThroughTheFloor) {
  MotionClip clip = WalkWithTips(Eigen::Vector3d(0, -0.06, 0.06));
  ASSERT_LT(LowestTip(clip), -0.01) << "nothing to bend";
  const MotionClip before = clip;
  BendToes(&clip);
  EXPECT_GT(LowestTip(clip), -0.0051);
  // Nothing but toes moves, and they by what lifts a tip of 8 cm by 2 cm, or a little more where the foot is pitched.
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < clip.joint_count(); ++j) {
      const bool toe = j == clip.skeleton().roles()[JointRole::kLeftToe] || j == clip.skeleton().roles()[JointRole::kRightToe];
      const double turned = clip.rotation(f, j).angularDistance(before.rotation(f, j));
      ASSERT_LT(turned, toe ? 1.0 : 1e-12) << j;
    }
  }
}

TEST(BendToes, LeavesFeetWithoutTipsAlone) {
  MotionClip clip = WalkWithTips(std::nullopt);
  clip.root_positions().row(1).array() -= 0.1;
  const MotionClip before = clip;
  BendToes(&clip);
  for (int j = 0; j < clip.joint_count(); ++j) EXPECT_EQ(clip.rotation(9, j).coeffs(), before.rotation(9, j).coeffs());
}

}  // namespace
}  // namespace morphograph
