#include "datasets/skeleton.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace morphograph {
namespace {

using ::testing::HasSubstr;

// Hips under a still root; a straight left leg of 0.4 + 0.5 m, a right one of 0.4 + 0.3 m.
std::vector<Joint> Legs() {
  return {{"Root", -1, {0, 0, 0}, {}, {}},           {"Hips", 0, {0, 0, 0}, {}, {}},
          {"LeftHip", 1, {0.1, 0, 0}, {}, {}},       {"LeftKnee", 2, {0, -0.4, 0}, {}, {}},
          {"LeftAnkle", 3, {0, -0.5, 0}, {}, {}},    {"RightHip", 1, {-0.1, 0, 0}, {}, {}},
          {"RightKnee", 5, {0, -0.4, 0}, {}, {}},    {"RightAnkle", 6, {0, -0.3, 0}, Eigen::Vector3d(0, -0.1, 0), {}},
          {"Prop", 0, {0, 1, 0}, {}, {}}};
}

RoleMap LegRoles() {
  RoleMap roles;
  roles.Set(JointRole::kHips, 1);
  roles.Set(JointRole::kLeftHip, 2);
  roles.Set(JointRole::kLeftKnee, 3);
  roles.Set(JointRole::kLeftAnkle, 4);
  roles.Set(JointRole::kRightHip, 5);
  roles.Set(JointRole::kRightKnee, 6);
  roles.Set(JointRole::kRightAnkle, 7);
  return roles;
}

std::string SkeletonError(std::vector<Joint> joints, const RoleMap& roles = {}, double metres_per_unit = 1) {
  try {
    Skeleton(std::move(joints), roles, metres_per_unit, UpAxis::kY);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Skeleton, KnowsItsJointsRolesAndLegs) {
  const Skeleton skeleton(Legs(), LegRoles(), 0.01, UpAxis::kZ);
  EXPECT_EQ(skeleton.joint_count(), 9);
  EXPECT_EQ(skeleton.parent(3), 2);
  EXPECT_EQ(skeleton.moving_root(), 1);
  EXPECT_EQ(skeleton.metres_per_unit(), 0.01);
  EXPECT_EQ(skeleton.up_axis(), UpAxis::kZ);
  EXPECT_DOUBLE_EQ(skeleton.leg_length_m(), (0.9 + 0.7) / 2);
  EXPECT_EQ(skeleton.Find("RightKnee"), 6);
  EXPECT_EQ(skeleton.Find("rightknee"), -1);
  EXPECT_EQ(skeleton.FindRoleOrName("left_ankle"), 4);
  EXPECT_EQ(skeleton.FindRoleOrName("LeftAnkle"), 4);
  EXPECT_EQ(skeleton.FindRoleOrName("head"), -1);
  for (const int inside : {1, 2, 4, 7}) EXPECT_TRUE(skeleton.IsBody(inside)) << inside;
  for (const int outside : {0, 8}) EXPECT_FALSE(skeleton.IsBody(outside)) << outside;
}

TEST(Skeleton, WithoutRolesTheFirstJointMovesAndThereAreNoLegs) {
  const Skeleton skeleton(Legs(), {}, 1, UpAxis::kY);
  EXPECT_EQ(skeleton.moving_root(), 0);
  EXPECT_EQ(skeleton.leg_length_m(), 0);
  for (int j = 0; j < skeleton.joint_count(); ++j) EXPECT_TRUE(skeleton.IsBody(j)) << j;
}

TEST(Skeleton, ParentsPrecedeTheirChildren) {
  EXPECT_EQ(SkeletonError(Legs()), "");
  EXPECT_THAT(SkeletonError({}), HasSubstr("no joints"));
  for (const auto& [joint, parent] : {std::pair{0, 0}, {0, 3}, {2, -1}, {2, -7}, {2, 2}, {2, 5}, {8, 9}, {8, 1000}}) {
    std::vector<Joint> joints = Legs();
    joints[static_cast<size_t>(joint)].parent = parent;
    EXPECT_THAT(SkeletonError(joints), HasSubstr("parent of joint '" + joints[static_cast<size_t>(joint)].name + "'")) << parent;
  }
}

TEST(Skeleton, NamesAreUniqueAndNumbersFinite) {
  std::vector<Joint> joints = Legs();
  joints[3].name.clear();
  EXPECT_THAT(SkeletonError(joints), HasSubstr("joint 3 has no name"));
  joints[3].name = "Hips";
  EXPECT_THAT(SkeletonError(joints), HasSubstr("two joints are called 'Hips'"));
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  joints = Legs();
  joints[4].offset_m.y() = nan;
  EXPECT_THAT(SkeletonError(joints), HasSubstr("offset of joint 'LeftAnkle'"));
  joints = Legs();
  joints[7].end_site_m->z() = inf;
  EXPECT_THAT(SkeletonError(joints), HasSubstr("offset of joint 'RightAnkle'"));
  for (const double unit : {0.0, -1.0, nan, inf}) EXPECT_THAT(SkeletonError(Legs(), {}, unit), HasSubstr("metres per unit")) << unit;
}

TEST(Skeleton, RolesPointToItsJoints) {
  RoleMap roles = LegRoles();
  roles.Set(JointRole::kHead, 9);
  EXPECT_THAT(SkeletonError(Legs(), roles), HasSubstr("role 'head'"));
}

}  // namespace
}  // namespace morphograph
