#pragma once

#include <optional>

#include "datasets/motion_clip.h"

namespace morphograph {

/// The first frame of a pose that the recording holds from there to its end although the body was still walking: nothing changes
/// any more for a fifth of a second or longer, after a frame in which the root moved faster than 0.3 m/s. Nobody stops within a
/// frame; whoever cut the recording held its last pose.
std::optional<int> FindHold(const MotionClip& clip);

struct EasedStopOptions {
  double before_s = 3;  // of the walk that is kept before the stop
  double ease_s = 1;    // in which the clock slows to rest; it plays half of this time of the recording
  double stand_s = 1;   // of standing afterwards
};

/// The end of a clip with a hold as a stop: the clock slows down smoothly, so that the body comes to rest in the held pose.
/// @param hold  as FindHold gives it. @throws std::invalid_argument when it is not a frame of the clip.
MotionClip EasedStop(const MotionClip& clip, int hold, const EasedStopOptions& options = {});

}  // namespace morphograph
