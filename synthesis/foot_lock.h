#pragma once

#include <Eigen/Core>

#include "graph/motion_graph.h"

namespace morphograph {

struct FootLockOptions {
  double loose_chance = 0.5;  // of being planted, from which a part of a foot begins to be held
  /// Part of the mean slide of captured planted feet that is left. They do slide: joints are not soles, feet roll and turn on the ball.
  /// A foot nailed to the floor is told from the capture at once.
  double slide = 0.35;
  double rolling = 0.55;      // part of the mean rise of captured planted feet over their standing height that is left
  double hold_s = 0.5;       // how long a slip has to last to be let through rather than taken out
  double ease_s = 0.06;       // time constant of easing into and out of a hold
  double level = 12;          // weight of a planted foot's height against that of leaving it where it is
  double stretch = 0.3;       // part of the way from where an ankle is to a straight leg that a foot may be brought down by
};

/// Holds planted feet as captured ones are held, by inverse kinematics of the legs.
///
/// What heel and ball of a foot do while they are planted was learned with the primitives: mean height and mean slide at every phase of a
/// step. The feet of drawn steps waver about that. The shift s of each ankle over the clip takes it out; it is the least of
///   sum_f |s|^2 + (hold_s)^2 c |ds/dt + slide of the part - learned slide|^2 + (ease_s)^4 |d2s/dt2|^2, over the floor, and of
///   sum_f s^2 + level c (height of the part + s - learned height)^2 + (ease_s)^4 (d2s/dt2)^2 in height,
/// c rising from 0 to 1 with the chance that the part is planted. So nothing is switched on or off, and swings stay as they are.
///
/// @param contacts  what the steps know of the feet, (kContactRows x frames).
void LockFeet(const FeetGeometry& feet, const PoseLayout& layout, const ContactProfile& contacts, const FootLockOptions& options,
              MotionClip* clip);

}  // namespace morphograph
