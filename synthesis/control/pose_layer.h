#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "datasets/forward_kinematics.h"
#include "datasets/motion_clip.h"

namespace morphograph {

/// What a joint of an arm or the head is to do in a span of frames; outside of it the body eases back to what it does anyway.
struct PoseGoal {
  int joint = -1;
  int first_frame = 0, last_frame = 0;
  /// Where the joint is to be, given the frame and the pose so far; coordinates that do not count repeat the pose's own.
  std::function<Eigen::Vector3d(int frame, const WorldPose& pose)> position;
  /// Or the turn about the world's axes that the joint is to make.
  std::function<Eigen::Vector3d(int frame, const WorldPose& pose)> turn;
  /// Rotations of all joints from which turns are limited, a little further where the clip goes further by itself; empty: from the clip before any goal. A walk that
  /// twists to please a goal must not lend its twist to the joints that finish it.
  std::vector<Eigen::Quaterniond> neutral = {};
};

/// The joints that a goal may use: from the joint up to the trunk, and for arms the joints of the trunk as well, which lean a little where the
/// arm alone does not reach. Empty for legs, trunk and root, which only the walk itself can move.
class LimbChain {
 public:
  LimbChain(const Skeleton& skeleton, int joint);
  bool empty() const { return links_.empty(); }

  struct Link {
    int joint = -1;
    bool is_elbow = false;  // turns about its hinge only
    double ease = 1;        // of moving it against the others
    double limit_rad = 1;   // of its turn
    int elbow = -1, wrist = -1;  // of a shoulder: the rest of its arm, see ArmRange
  };
  /// From the joint up; the first `limb_size()` are the limb's own, the rest the trunk's.
  const std::vector<Link>& links() const { return links_; }
  size_t limb_size() const { return limb_size_; }
  /// The joint that the limb hangs from. @throws std::out_of_range where it is empty.
  int base() const { return links_.at(limb_size_ - 1).joint; }

 private:
  std::vector<Link> links_;
  size_t limb_size_ = 0;
};

/// Turns the joints of arms or head, no more than it takes (damped least squares) and within what they can (ArmRange and limits of each joint), so that
/// a goal is met in each frame of its span; eases in and out over a time that grows with the turn. What is out of reach stays missed.
/// @param before  the clip before any goal: limits are of the turns away from that or from PoseGoal::neutral, however many goals a limb has.
/// @return how many poses were worked out on the way.
int ApplyPoseGoal(const PoseGoal& goal, const MotionClip& before, MotionClip* clip);

}  // namespace morphograph
