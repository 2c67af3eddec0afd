#pragma once

#include <Eigen/Core>

#include "graph/motion_graph.h"

namespace morphograph {

struct FootLockOptions {
  double planted_chance = 0.5;  // from which a part of a foot counts as planted
  double shortest_s = 0.1;      // shorter stances are left alone
  double ease_s = 0.13;         // into and out of a stance
  double corner_s = 0.025;      // standard deviation of the filter that rounds the corners of the correction
};

/// Holds planted feet where they stand, by inverse kinematics of the legs.
///
/// While the ball of a foot is planted it stays on one spot at its learned height; while only the heel is, the heel does. Which is
/// when was learned with the primitives. Corrections ease in and out over the swing, matched in velocity.
///
/// @param contacts  chance that each part of the feet is planted (4 x frames), as in ContactTrack.
void LockFeet(const FeetGeometry& feet, const Eigen::Matrix4Xd& contacts, const FootLockOptions& options, MotionClip* clip);

}  // namespace morphograph
