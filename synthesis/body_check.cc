#include "synthesis/body_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace morphograph {
namespace {

struct Leg {
  JointRole hip, knee, ankle, ball;
};
constexpr Leg kLegs[2] = {
    {JointRole::kLeftHip, JointRole::kLeftKnee, JointRole::kLeftAnkle, JointRole::kLeftToe},
    {JointRole::kRightHip, JointRole::kRightKnee, JointRole::kRightAnkle, JointRole::kRightToe}};

}  // namespace

double KneeFlexionDeg(const Eigen::Vector3d& hip, const Eigen::Vector3d& knee, const Eigen::Vector3d& ankle,
                      const Eigen::Vector3d& ball, const Eigen::Vector3d& pelvis_left) {
  const Eigen::Vector3d thigh = (knee - hip).normalized();
  const Eigen::Vector3d shank = (ankle - knee).normalized();
  const Eigen::Vector3d foot_left = (ball - ankle).normalized().cross(shank);
  const Eigen::Vector3d axis = (pelvis_left.normalized() + foot_left).normalized();
  return std::atan2(thigh.cross(shank).dot(axis), thigh.dot(shank)) * 180 / std::numbers::pi;
}

BodyCheck CheckBody(const EvaluationMotion& motion) {
  const Skeleton& skeleton = *motion.skeleton;
  const RoleMap& roles = skeleton.roles();
  if (const std::vector<std::string> missing = roles.Missing(LocomotionRoles()); !missing.empty()) {
    throw std::invalid_argument("CheckBody: the skeleton has no joint for role '" + missing.front() + "'");
  }
  BodyCheck check;
  check.min_knee_flexion_deg = check.lowest_m = std::numeric_limits<double>::infinity();
  check.max_knee_flexion_deg = -std::numeric_limits<double>::infinity();
  const auto above = [&](const Eigen::Vector3d& point) { return point.y() - motion.ground.HeightAt(point); };
  for (int f = 0; f < motion.frame_count(); ++f) {
    const Eigen::Matrix3Xd& positions = motion.joint_positions[static_cast<size_t>(f)];
    const Eigen::Vector3d pelvis_left =
        positions.col(roles[JointRole::kLeftHip]) - positions.col(roles[JointRole::kRightHip]);
    for (int side = 0; side < 2; ++side) {
      const Leg& leg = kLegs[side];
      const Eigen::Vector3d ankle = positions.col(roles[leg.ankle]);
      const double flexion = KneeFlexionDeg(positions.col(roles[leg.hip]), positions.col(roles[leg.knee]),
                                            ankle, positions.col(roles[leg.ball]), pelvis_left);
      check.min_knee_flexion_deg = std::min(check.min_knee_flexion_deg, flexion);
      check.max_knee_flexion_deg = std::max(check.max_knee_flexion_deg, flexion);
      check.lowest_m = std::min({check.lowest_m, above(ankle), above(motion.contacts.heels[side].col(f)),
                                 above(motion.contacts.balls[side].col(f))});
    }
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      if (!skeleton.IsBody(j) || j == skeleton.moving_root()) continue;
      const double length = (positions.col(j) - positions.col(skeleton.parent(j))).norm();
      check.bone_length_error_m =
          std::max(check.bone_length_error_m, std::abs(length - skeleton.joint(j).offset_m.norm()));
    }
  }
  return check;
}

}  // namespace morphograph
