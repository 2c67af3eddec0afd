#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "datasets/forward_kinematics.h"
#include "datasets/skeleton.h"

namespace morphograph {

/// Which way an upper arm may point against the trunk, and how far it may turn about itself.
///
/// In the trunk's frame (x out of the body on the arm's side, y from the hip joints up to the shoulders, z ahead) a unit vector u along the
/// upper arm keeps to what two caps of the sphere have in common: u . axis >= cos(half angle); one keeps it from far behind the trunk, the
/// other from far across it. Its turn about itself is that of the elbow's hinge, against the hinge of a reference pose brought to u by the
/// least rotation. arm_range.cc has the figures and says where they come from.
class ArmRange {
 public:
  /// @param pose  what the trunk does; an arm that is out of range there may go on being so, but no farther.
  /// @param shoulder, elbow, wrist  joints of one arm, each above the next. Without the roles of both shoulders and both hips nothing is
  ///   out of range.
  ArmRange(const Skeleton& skeleton, const WorldPose& pose, int shoulder, int elbow, int wrist);

  /// The turn of the upper arm, about the world's axes, that brings it back into range; none where it lies within.
  /// @param pose  of the arm, and of the trunk, which may lean otherwise than in the pose above.
  std::optional<Eigen::Quaterniond> Back(const WorldPose& pose) const;

  /// How far out of range a pose of the arm is, rad; 0 within.
  double Excess(const WorldPose& pose) const;

 private:
  static constexpr int kCaps = 2;
  struct Arm {
    Eigen::Vector3d upper, lower;  // in the trunk's frame
  };
  Arm ArmOf(const WorldPose& pose) const;
  Eigen::Matrix3d WorldFromTrunk(const WorldPose& pose) const;

  int shoulder_, elbow_, wrist_;
  int trunk_ = -1;  // the joint that both shoulders hang from
  Eigen::Matrix3d joint_from_trunk_ = Eigen::Matrix3d::Identity();  // from the trunk's frame to that joint's; a reflection too on the right
  double half_angle_rad_[kCaps] = {};
  double least_twist_rad_ = 0, most_twist_rad_ = 0;
};

}  // namespace morphograph
