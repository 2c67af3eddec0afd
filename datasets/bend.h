#pragma once

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"

namespace morphograph {

struct BendOptions {
  double turn_per_step_rad = 0.2;  // of the path, positive towards +X when walking along +Z; |turn| <= 0.6
  /// The turn rate grows from zero over the first and fades over the last `ease_s` seconds of walking.
  double ease_s = 0.6;
};

/// A captured walk led along a curve (METHODS, "Data that the clips lack").
///
/// The heading of every frame is turned by an angle that grows with the distance walked, `turn_per_step_rad` for each step's length, so
/// that standing does not turn; the root's moves are turned with it. Each planted foot keeps the place and orientation that it has
/// in the middle of its stance, moved there as a whole; swing feet pass from the one to the next; leg inverse kinematics puts ankles
/// there. Where the longer way of the outer foot would stretch a leg beyond what it reaches, the pelvis sinks a little. Trunk
/// and arms are the capture's own: nobody leans into the bend.
///
/// @param contacts  of `clip`. The floor must be level (LevelFloor).
/// @throws std::invalid_argument when leg roles are missing, sizes do not match or the turn is out of range.
MotionClip Bent(const MotionClip& clip, const ContactTrack& contacts, const BendOptions& options = {});

}  // namespace morphograph
