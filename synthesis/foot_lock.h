#pragma once

#include <Eigen/Core>

#include "graph/motion_graph.h"

namespace morphograph {

struct FootLockOptions {
  double loose_chance = 0.5;  // of being planted, from which a part of a foot begins to be held
  /// Part of the slide of captured planted feet that is left. They do slide: joints are not soles, feet roll and turn on the ball.
  /// A foot nailed to the floor is told from the capture at once.
  double slide = 0.35;
  /// Part of the rise of captured planted feet over their standing height that is left. What they sink below it is left whole.
  double rolling = 0.89;
  double hold_s = 0.5;       // how long a slip has to last to be let through rather than taken out
  double ease_s = 0.06;       // time constant of easing into and out of a hold
  double level = 24;          // weight of a planted foot's height against that of leaving it where it is
  double stretch = 0.3;       // part of the way from where an ankle is to a straight leg that a foot may be brought down by
};

/// Where a planted part of a foot is held that stands at one height and is at another in the capture, at that phase of such a step.
inline double HeldHeight_m(double standing_m, double learned_m, const FootLockOptions& options = {}) {
  return learned_m > standing_m ? standing_m + options.rolling * (learned_m - standing_m) : learned_m;
}

/// Holds planted feet as captured ones are held, by inverse kinematics of the legs.
///
/// What heel and ball of a foot do while they are planted was learned with the primitives: height and slide at every phase of a step, as its
/// latent tells them. The feet of drawn steps waver about that. The shift s of each ankle over the clip takes it out; it is the least of
///   sum_f |s|^2 + (hold_s)^2 c |ds/dt + slide of the part - learned slide|^2 + (ease_s)^4 |d2s/dt2|^2, over the floor, and of
///   sum_f s^2 + level c (height of the part + s - learned height)^2 + (ease_s)^4 (d2s/dt2)^2 in height,
/// c rising from 0 to 1 with the chance that the part is planted. So nothing is switched on or off, and swings stay as they are. What a leg
/// would have to be stretched further for than `stretch` lets it, the body comes down by: the drop d (5 cm at most) that is the least of
///   sum_f d^2 + level c (what the leg is short of - d)^2 + (ease_s)^4 (d2d/dt2)^2, of two short legs the one that asks for more.
///
/// @param contacts  what the steps know of the feet, (kContactRows x frames): heights and velocities of the very steps, where their latents
///   tell them (MotionPrimitive::Contacts).
void LockFeet(const FeetGeometry& feet, const PoseLayout& layout, const ContactProfile& contacts, const FootLockOptions& options,
              MotionClip* clip);

}  // namespace morphograph
