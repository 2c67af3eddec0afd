#include "synthesis/sensors/motion_base.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tests/synthesis/gait_clips.h"

namespace morphograph {
namespace {

// The clip on its skeleton with one more joint at the end, below `parent`.
MotionClip WithJoint(const MotionClip& clip, const std::string& name, const std::string& parent) {
  const Skeleton& skeleton = clip.skeleton();
  std::vector<Joint> joints = skeleton.joints();
  Joint joint = joints.back();
  joint.name = name;
  joint.parent = skeleton.Find(parent);
  joint.offset_m = {0.1, 0, 0};
  joints.push_back(joint);
  MotionClip longer(std::make_shared<Skeleton>(joints, skeleton.roles(), skeleton.metres_per_unit(), skeleton.up_axis()), clip.frame_rate_hz(), clip.frame_count());
  longer.root_positions() = clip.root_positions();
  for (int f = 0; f < clip.frame_count(); ++f) std::copy_n(clip.rotations(f), clip.joint_count(), &longer.rotation(f, 0));
  return longer;
}

TEST(MotionBase, FingersAreNotMeasured) {
  const MotionClip bare = testing::GaitClip(1);
  const auto measured = [](const MotionClip& clip) { return MotionBase({clip}, {}, {}).measured_joints(); };
  const std::vector<int> without = measured(bare);
  EXPECT_EQ(std::count(without.begin(), without.end(), bare.skeleton().Find("LeftHand")), 1) << "wrists are";
  EXPECT_EQ(std::count(without.begin(), without.end(), bare.skeleton().moving_root()), 0);
  EXPECT_EQ(measured(WithJoint(bare, "LeftHandIndex1", "LeftHand")), without);
  const MotionClip fingered = WithJoint(bare, "LeftHandIndex1", "LeftHand");
  EXPECT_EQ(MotionBase({fingered}, PlacementsAtJoints({"LeftHandIndex1"}), {}).measured_joints().size(), without.size() + 1) << "but those with a sensor are";
  const MotionClip horned = WithJoint(bare, "Horn", "Head");
  EXPECT_EQ(measured(horned).size(), without.size() + 1);
  EXPECT_EQ(measured(horned).back(), horned.skeleton().Find("Horn"));
}

}  // namespace
}  // namespace morphograph
