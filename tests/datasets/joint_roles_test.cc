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

// Names of hips, left hip, knee, ankle, toe, shoulder, elbow, wrist, right knee; spine, chest, neck, head.
TEST(JointRoles, FindsTheRigsOfTheWild) {
  const std::vector<std::vector<std::string>> rigs = {
      {"Bip01 Pelvis", "Bip01 L Thigh", "Bip01 L Calf", "Bip01 L Foot", "Bip01 L Toe0", "Bip01 L UpperArm", "Bip01 L Forearm",
       "Bip01 L Hand", "Bip01 R Calf", "Bip01 Spine", "Bip01 Spine2", "Bip01 Neck", "Bip01 Head", "Bip01", "Bip01 L Clavicle",
       "Bip01 Spine1"},
      {"pelvis", "thigh_l", "calf_l", "foot_l", "ball_l", "upperarm_l", "lowerarm_l", "hand_l", "calf_r", "spine_01", "spine_03",
       "neck_01", "head", "root", "clavicle_l", "spine_02"},
      {"Pelvis", "LeftUpperLeg", "LeftLowerLeg", "LeftFoot", "LeftToe", "LeftUpperArm", "LeftForeArm", "LeftHand",
       "RightLowerLeg", "L5", "T8", "Neck", "Head", "LeftShoulder", "L3", "T12"},
      {"Hips", "LeftThigh", "LeftShin", "LeftFoot", "LeftToe", "LeftArm", "LeftForeArm", "LeftHand", "RightShin", "Spine",
       "Spine2", "Neck", "Head", "LeftShoulder", "Spine1"},
      {"Pelvis", "L_Hip", "L_Knee", "L_Ankle", "L_Foot", "L_Shoulder", "L_Elbow", "L_Wrist", "R_Knee", "Spine1", "Spine3", "Neck",
       "Head", "L_Collar", "L_Hand", "Spine2"},
      {"mixamorig1_Hips", "mixamorig1_LeftUpLeg", "mixamorig1_LeftLeg", "mixamorig1_LeftFoot", "mixamorig1_LeftToeBase",
       "mixamorig1_LeftArm", "mixamorig1_LeftForeArm", "mixamorig1_LeftHand", "mixamorig1_RightLeg", "mixamorig1_Spine",
       "mixamorig1_Spine2", "mixamorig1_Neck", "mixamorig1_Head", "mixamorig1_LeftShoulder", "mixamorig1_Spine1"},
      {"root", "lfemur", "ltibia", "lfoot", "ltoes", "lhumerus", "lradius", "lwrist", "rtibia", "lowerback", "thorax", "lowerneck",
       "head", "lclavicle", "lhand", "lhipjoint", "upperback"},
      {"hips", "upleg.L", "lowleg.L", "foot.L", "toe.L", "upper_arm.L", "forearm.L", "hand.L", "lowleg.R", "spine", "chest", "neck",
       "head", "shoulder.L"},
      {"rig|Hips", "UpLeg_Left", "Leg_Left", "Foot_Left", "Toe_Left", "Arm_Left", "ForeArm_Left", "Hand_Left", "Leg_Right",
       "Spine", "Chest", "Neck", "Head"},
  };
  const JointRole expected[] = {JointRole::kHips, JointRole::kLeftHip, JointRole::kLeftKnee, JointRole::kLeftAnkle,
                                JointRole::kLeftToe, JointRole::kLeftShoulder, JointRole::kLeftElbow, JointRole::kLeftWrist,
                                JointRole::kRightKnee, JointRole::kSpine, JointRole::kChest, JointRole::kNeck, JointRole::kHead};
  for (const auto& names : rigs) {
    const RoleMap roles = DetectRoles(names);
    for (int i = 0; i < 13; ++i) EXPECT_EQ(roles[expected[i]], i) << RoleName(expected[i]) << " of " << names[i];
    EXPECT_FALSE(roles.Has(JointRole::kRightHip)) << names[0];
  }
}

TEST(JointRoles, NoJointHasTwoRoles) {
  const RoleMap roles = DetectRoles({"Hips", "Chest", "LeftFoot"});
  EXPECT_EQ(roles[JointRole::kChest], 1);
  EXPECT_FALSE(roles.Has(JointRole::kSpine));
  EXPECT_EQ(roles[JointRole::kLeftAnkle], 2);
  EXPECT_FALSE(roles.Has(JointRole::kLeftToe));
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
