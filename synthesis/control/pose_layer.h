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
};

/// The joints that a goal may use: from the joint up to the trunk, which stays as it is. Empty for legs, trunk and root, which only the walk
/// itself can move.
class LimbChain {
 public:
  LimbChain(const Skeleton& skeleton, int joint);
  bool empty() const { return links_.empty(); }

  struct Link {
    int joint = -1;
    bool is_elbow = false;  // turns about its hinge only
    double ease = 1;        // of moving it against the others
    double limit_rad = 1;   // of its turn
  };
  const std::vector<Link>& links() const { return links_; }

 private:
  std::vector<Link> links_;
};

/// Turns the joints of arms or head, no more than it takes (damped least squares) and within what they can, so that a goal is met in each frame
/// of its span; eases in and out over a time that grows with the turn. What is out of reach stays missed.
/// @param before  the clip before any goal: limits are of the turns away from that, however many goals a limb has.
void ApplyPoseGoal(const PoseGoal& goal, const MotionClip& before, MotionClip* clip);

}  // namespace morphograph
