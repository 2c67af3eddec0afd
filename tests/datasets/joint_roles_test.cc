#include "datasets/joint_roles.h"

#include <gtest/gtest.h>

namespace morphograph {
namespace {

TEST(JointRoles, FindsBothRealDialectsAndMixamo) {
  const std::vector<std::vector<std::string>> dialects = {
      {"Hips", "LHipJoint", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase", "LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand"},
      {"joint_Root", "Hips", "UpperLeg_L", "LowerLeg_L", "Foot_L", "Toes_L", "Shoulder_L", "UpperArm_L", "LowerArm_L", "Hand_L"},
      {"mixamorig:Hips", "mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot", "mixamorig:LeftToeBase", "mixamorig:LeftShoulder",
       "mixamorig:LeftArm", "mixamorig:LeftForeArm", "mixamorig:LeftHand"},
      {"Hips", "LeftHip", "LeftKnee", "LeftAnkle", "LeftToe", "LeftCollar", "LeftShoulder", "LeftElbow", "LeftWrist"}};
  for (const auto& names : dialects) {
    const RoleMap roles = DetectRoles(names);
    EXPECT_EQ(names[roles[JointRole::kHips]].find("ips") != std::string::npos, true) << names[0];
    const int last = static_cast<int>(names.size()) - 1;
    EXPECT_EQ(roles[JointRole::kLeftWrist], last) << names[0];
    EXPECT_EQ(roles[JointRole::kLeftElbow], last - 1) << names[0];
    EXPECT_EQ(roles[JointRole::kLeftShoulder], last - 2) << names[0];
    EXPECT_EQ(roles[JointRole::kLeftToe], last - 4) << names[0];
    EXPECT_EQ(roles[JointRole::kLeftHip], last - 7) << names[0];
    EXPECT_FALSE(roles.Has(JointRole::kRightHip)) << names[0];
  }
}

TEST(JointRoles, MirrorIsAnInvolutionAndNamesRoundTrip) {
  for (int i = 0; i < kJointRoleCount; ++i) {
    const auto role = static_cast<JointRole>(i);
    EXPECT_EQ(MirroredRole(MirroredRole(role)), role);
    EXPECT_EQ(RoleFromName(RoleName(role)), role);
  }
}

}  // namespace
}  // namespace morphograph
