#include "synthesis/smoothness.h"

#include <gtest/gtest.h>

namespace morphograph {
namespace {

Skeleton OneJoint() {
  RoleMap roles;
  roles.Set(JointRole::kHips, 0);
  Joint joint;
  joint.name = "Hips";
  return Skeleton({joint}, roles, 1, UpAxis::kY);
}

TEST(Smoothness, OfAThrownPointIsGravityAndNoJerk) {
  std::vector<Eigen::Matrix3Xd> positions;
  for (int f = 0; f < 20; ++f) {
    const double t = f / 30.0;
    positions.push_back(Eigen::Vector3d(3 * t, 2 * t - 0.5 * 9.81 * t * t, -t));
  }
  const std::vector<double> accelerations = JointAccelerations(OneJoint(), positions, 30);
  ASSERT_EQ(accelerations.size(), 18u);
  for (const double a : accelerations) EXPECT_NEAR(a, 9.81, 1e-9);
  for (const double j : JointJerks(OneJoint(), positions, 30)) EXPECT_NEAR(j, 0, 1e-7);
}

TEST(Smoothness, OfACubicPathIsItsJerk) {
  std::vector<Eigen::Matrix3Xd> positions;
  for (int f = 0; f < 10; ++f) positions.push_back(Eigen::Vector3d(0, 0, std::pow(f / 120.0, 3)));
  const std::vector<double> jerks = JointJerks(OneJoint(), positions, 120);
  ASSERT_EQ(jerks.size(), 7u);
  for (const double j : jerks) EXPECT_NEAR(j, 6, 1e-6);
}

TEST(Smoothness, OfTooFewFramesIsEmpty) {
  const std::vector<Eigen::Matrix3Xd> positions(2, Eigen::Matrix3Xd::Zero(3, 1));
  EXPECT_TRUE(JointAccelerations(OneJoint(), positions, 30).empty());
  EXPECT_TRUE(JointJerks(OneJoint(), positions, 30).empty());
}

}  // namespace
}  // namespace morphograph
