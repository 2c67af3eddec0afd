#pragma once

#include "datasets/motion_clip.h"

namespace morphograph {

/// The clip at another frame rate, from the first frame to at most the last: cubic interpolation of positions and of
/// rotations in the tangent space, low-passed first when the rate falls below half of the source's.
MotionClip Resample(const MotionClip& clip, double frame_rate_hz);

}  // namespace morphograph
