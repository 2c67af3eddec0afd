#include "synthesis/control/arm_range.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace morphograph {
namespace {

constexpr double kDegree = 0.017453292519943295;

// Where the figures come from: the arms of all recordings at hand (bnr: walks, turns, runs; cmu: walks, runs, jumps, a dance, climbing; 60,000 poses
// of 30 a second, both sides). The axes were chosen so that an arm that hangs may be led farther back than one at shoulder height, the more so the more it points
// outwards, and that an arm led back may come less far across than one in front. The 99.9th percentiles of the angles from them are 119 degrees (runs, elbows
// bent; walks and the others 109 to 112) and 114 degrees (walks; runs and the others 102 to 112), and turns of the upper arm about itself lie between -84 and
// 110 degrees. A little is added to each: arms that are told where to go may go a little farther than those that were seen.
struct Cap {
  Eigen::Vector3d axis;  // in the trunk's frame
  double half_angle_rad;
};
constexpr double kMargin_rad = 2 * kDegree, kTwistMargin_rad = 5 * kDegree;
const Cap kRange[2] = {{Eigen::Vector3d(1, -1.7, 2.62).normalized(), 119 * kDegree + kMargin_rad}, {Eigen::Vector3d(1, 0, 0.54).normalized(), 114 * kDegree + kMargin_rad}};
constexpr double kLeastTwist_rad = -84 * kDegree - kTwistMargin_rad, kMostTwist_rad = 110 * kDegree + kTwistMargin_rad;
// The reference pose: the upper arm down, ahead and a little out, the forearm bent forwards.
const Eigen::Vector3d kReferenceArm = Eigen::Vector3d(0.4, -0.6, 0.7).normalized();
const Eigen::Vector3d kReferenceHinge = Eigen::Vector3d(-Eigen::Vector3d::UnitX() + kReferenceArm.x() * kReferenceArm).normalized();

constexpr double kStraight = 0.2;       // sine of the flexion of an elbow, below which its hinge is not seen
constexpr double kNegligible_rad = 1e-4;

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Turn of an upper arm about itself, all in the trunk's frame; none where the elbow is too straight, or the arm points away from the reference.
std::optional<double> Twist(const Eigen::Vector3d& upper, const Eigen::Vector3d& lower) {
  const Eigen::Vector3d arm = upper.normalized(), hinge = arm.cross(lower.normalized());
  if (hinge.norm() < kStraight || arm.dot(kReferenceArm) < -0.999) return std::nullopt;
  const Eigen::Vector3d reference = Eigen::Quaterniond::FromTwoVectors(kReferenceArm, arm) * kReferenceHinge;
  return std::atan2(reference.cross(hinge).dot(arm), reference.dot(hinge));
}

}  // namespace

ArmRange::ArmRange(const Skeleton& skeleton, const WorldPose& pose, int shoulder, int elbow, int wrist) : shoulder_(shoulder), elbow_(elbow), wrist_(wrist) {
  const RoleMap& roles = skeleton.roles();
  for (const JointRole role : {JointRole::kLeftShoulder, JointRole::kRightShoulder, JointRole::kLeftHip, JointRole::kRightHip}) {
    if (!roles.Has(role)) return;
  }
  const int other = roles[shoulder == roles[JointRole::kLeftShoulder] ? JointRole::kRightShoulder : JointRole::kLeftShoulder];
  std::vector<char> above(static_cast<size_t>(skeleton.joint_count()), 0);
  for (int j = shoulder; j >= 0; j = skeleton.parent(j)) above[static_cast<size_t>(j)] = 1;
  trunk_ = other;
  while (!above[static_cast<size_t>(trunk_)]) trunk_ = skeleton.parent(trunk_);
  const auto at = [&](JointRole role) -> Eigen::Vector3d { return pose.positions.col(roles[role]); };
  const Eigen::Vector3d left = at(JointRole::kLeftShoulder), right = at(JointRole::kRightShoulder);
  const Eigen::Vector3d up = (left + right - at(JointRole::kLeftHip) - at(JointRole::kRightHip)).normalized();
  const Eigen::Vector3d to_left = (left - right - up * up.dot(left - right)).normalized();
  const double side = shoulder == roles[JointRole::kLeftShoulder] ? 1 : -1;
  Eigen::Matrix3d world_from_trunk;
  world_from_trunk << side * to_left, up, to_left.cross(up);
  joint_from_trunk_ = pose.rotations[static_cast<size_t>(trunk_)].conjugate() * world_from_trunk;
  const Arm arm = ArmOf(pose);
  for (int i = 0; i < kCaps; ++i) half_angle_rad_[i] = std::max(kRange[i].half_angle_rad, Angle(kRange[i].axis, arm.upper));
  const double twist = Twist(arm.upper, arm.lower).value_or(0);
  least_twist_rad_ = std::min(kLeastTwist_rad, twist);
  most_twist_rad_ = std::max(kMostTwist_rad, twist);
}

Eigen::Matrix3d ArmRange::WorldFromTrunk(const WorldPose& pose) const { return pose.rotations[static_cast<size_t>(trunk_)] * joint_from_trunk_; }

ArmRange::Arm ArmRange::ArmOf(const WorldPose& pose) const {
  const Eigen::Matrix3d trunk_from_world = WorldFromTrunk(pose).transpose();
  const Eigen::Vector3d elbow = pose.positions.col(elbow_);
  return {trunk_from_world * (elbow - pose.positions.col(shoulder_)), trunk_from_world * (pose.positions.col(wrist_) - elbow)};
}

double ArmRange::Excess(const WorldPose& pose) const {
  if (trunk_ < 0) return 0;
  const Arm arm = ArmOf(pose);
  double excess = 0;
  for (int i = 0; i < kCaps; ++i) excess = std::max(excess, Angle(kRange[i].axis, arm.upper) - half_angle_rad_[i]);
  if (const auto twist = Twist(arm.upper, arm.lower)) excess = std::max({excess, least_twist_rad_ - *twist, *twist - most_twist_rad_});
  return excess;
}

std::optional<Eigen::Quaterniond> ArmRange::Back(const WorldPose& pose) const {
  if (Excess(pose) < kNegligible_rad) return std::nullopt;
  const Arm arm = ArmOf(pose);
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // about the trunk's axes
  // Back into one cap may be out of the other; where their borders cross, alternating comes close.
  for (int round = 0; round < 8; ++round) {
    bool within = true;
    for (int i = 0; i < kCaps; ++i) {
      const Eigen::Vector3d now = turn * arm.upper, hinge = now.cross(kRange[i].axis);
      const double excess = Angle(kRange[i].axis, now) - half_angle_rad_[i];
      if (excess < kNegligible_rad) continue;
      within = false;
      // From the axis' other end any way leads back.
      const Eigen::Vector3d about = hinge.norm() > 1e-9 ? Eigen::Vector3d(hinge.normalized()) : kRange[i].axis.unitOrthogonal();
      turn = Eigen::AngleAxisd(excess, about) * turn;
    }
    if (within) break;
  }
  const Eigen::Vector3d now = (turn * arm.upper).normalized();
  if (const auto twist = Twist(now, turn * arm.lower)) turn = Eigen::AngleAxisd(std::clamp(*twist, least_twist_rad_, most_twist_rad_) - *twist, now) * turn;
  // A reflection turns the sense of rotations.
  const Eigen::Matrix3d world_from_trunk = WorldFromTrunk(pose);
  const double sense = world_from_trunk.determinant() < 0 ? -1 : 1;
  Eigen::Quaterniond world;
  world.w() = turn.w();
  world.vec() = sense * (world_from_trunk * turn.vec());
  return world;
}

}  // namespace morphograph
