#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/skeleton.h"

namespace morphograph {

struct LegIkOptions {
  /// Width of the soft limit before full extension, as a fraction of the straight leg's length. Targets inside the last
  /// `soft_zone` are approached exponentially, so that a leg that runs out of reach slows down instead of snapping straight.
  double soft_zone = 0.004;
  double max_knee_bend_rad = 2.6;
};

/// Where a leg is, in the world.
struct LegPlace {
  Eigen::Vector3d hip_m, knee_m, ankle_m, toe_m;
  Eigen::Quaterniond world_from_foot;  // of the ankle joint
};

/// What a leg does in a pose.
struct LegMeasure : LegPlace {
  double knee_bend_rad = 0;  // 0 straight, positive bent the human way, negative hyperextended
};

struct LegSolution {
  double miss_m = 0;         // distance from the ankle to its target: 0 unless out of reach
  double knee_bend_rad = 0;  // >= 0
};

/// Analytic two-bone inverse kinematics of one leg, for any hierarchy with leg roles.
///
/// Two exact steps, both minimal, so that a target equal to the pose's own ankle changes nothing:
/// 1. the knee turns about the hinge axis that the pose itself shows (thigh x shin), until hip and ankle are as far apart as
///    hip and target. Where the leg is nearly straight, or bent backwards, that axis says little; it is pulled towards the
///    axis that the foot's direction and the pelvis tell, always so far that the knee bends forwards;
/// 2. the whole leg swings, without twist, from the old ankle direction to the target's.
/// The foot then takes the asked orientation. Joints between hip and knee, knee and ankle keep their local rotations; zero
/// offsets are fine.
///
/// Immutable after construction, safe to share between threads. No allocation in `Place`, `Measure` and `Solve`.
class LegIk {
 public:
  /// @throws std::invalid_argument when a role of LocomotionRoles() is missing, or hip, knee, ankle and toe do not follow
  /// each other down the hierarchy, or thigh or shin has no length.
  LegIk(const Skeleton& skeleton, Foot side, const LegIkOptions& options = {});

  /// Puts the ankle on `ankle_m`.
  ///
  /// @param ankle_m  target of the ankle joint, world.
  /// @param world_from_foot  orientation of the ankle joint; when empty, the foot keeps its world orientation.
  /// @param root_m  position of the moving root.
  /// @param rotations  local rotations of one frame, `joint_count()` of them; hip, knee and ankle are edited in place.
  LegSolution Solve(const Eigen::Vector3d& ankle_m, const std::optional<Eigen::Quaterniond>& world_from_foot,
                    const Eigen::Vector3d& root_m, Eigen::Quaterniond* rotations) const;

  LegPlace Place(const Eigen::Vector3d& root_m, const Eigen::Quaterniond* rotations) const;
  LegMeasure Measure(const Eigen::Vector3d& root_m, const Eigen::Quaterniond* rotations) const;

  /// Hip to ankle with the leg stretched (of the bones alone).
  double length_m() const { return thigh_m_ + shin_m_; }
  int hip() const { return hip_; }
  int knee() const { return knee_; }
  int ankle() const { return ankle_; }
  int toe() const { return toe_; }

 private:
  struct Link {
    int joint;
    Eigen::Vector3d offset_m;
  };
  struct Chain;  // the leg of one pose in the world

  Chain Follow(const Eigen::Vector3d& root_m, const Eigen::Quaterniond* rotations) const;
  Eigen::Vector3d ToldHinge(const Chain& chain) const;

  LegIkOptions options_;
  std::vector<Link> links_;  // from below the moving root to the toe
  int root_, hip_, knee_, ankle_, toe_;
  double thigh_m_ = 0, shin_m_ = 0;
  Eigen::Vector3d root_across_;  // right hip to left hip, in the moving root's frame
};

}  // namespace morphograph
