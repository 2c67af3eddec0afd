#include "synthesis/body_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace morphograph {
namespace {

// A leg facing +Z whose knee is bent by `flexion_deg` (negative: backwards), turned about the vertical and
// tilted forward.
double FlexionOfPosedLeg(double flexion_deg, double yaw_rad, double swing_rad, double toe_out_rad = 0) {
  const double bend = flexion_deg * std::numbers::pi / 180;
  const Eigen::Matrix3d thigh = Eigen::AngleAxisd(-swing_rad, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d shank = thigh * Eigen::AngleAxisd(bend, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d hip(0.1, 0.9, 0), knee = hip + thigh * Eigen::Vector3d(0, -0.45, 0);
  const Eigen::Vector3d ankle = knee + shank * Eigen::Vector3d(0, -0.42, 0);
  const Eigen::Vector3d toes =
      Eigen::AngleAxisd(toe_out_rad, Eigen::Vector3d::UnitY()) * Eigen::Vector3d(0, -0.06, 0.13);
  const Eigen::Vector3d ball = ankle + shank * toes;
  const Eigen::AngleAxisd turn(yaw_rad, Eigen::Vector3d::UnitY());
  return KneeFlexionDeg(turn * hip, turn * knee, turn * ankle, turn * ball,
                        turn * Eigen::Vector3d(0.2, 0, 0));
}

TEST(KneeFlexion, IsTheBendWhicheverWayTheBodyFaces) {
  for (const double yaw : {0.0, 1.0, 2.5, -2.0}) {
    for (const double flexion : {0.0, 5.0, 30.0, 75.0, 120.0}) {
      EXPECT_NEAR(FlexionOfPosedLeg(flexion, yaw, 0.4), flexion, 1e-9) << "yaw " << yaw;
    }
  }
}

TEST(KneeFlexion, IsNegativeWhenTheKneeBendsBack) {
  for (const double yaw : {0.0, 1.0, 2.5, -2.0}) EXPECT_NEAR(FlexionOfPosedLeg(-10, yaw, 0.2), -10, 1e-9);
}

TEST(KneeFlexion, KeepsItsSignWithTheFootTurnedOut) {
  EXPECT_NEAR(FlexionOfPosedLeg(20, 0.7, 0.1, 0.5), 20, 1.5);
  EXPECT_NEAR(FlexionOfPosedLeg(-20, 0.7, 0.1, 0.5), -20, 1.5);
}

}  // namespace
}  // namespace morphograph
