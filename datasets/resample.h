#pragma once

#include "datasets/motion_clip.h"

namespace morphograph {

/// The clip at another frame rate, from the first frame to at most the last; frames that fall on source frames when the
/// rate rises are those frames.
///
/// When the rate rises, positions run along Catmull-Rom cubics and rotations do so in the tangent space of the
/// frame before. When it falls, each output frame is the mean of the frames around it, weighted by a windowed sinc that
/// passes what the lower rate can hold (linear, zero phase; rotations again averaged in a tangent space). The ends
/// are continued by point reflection, so that a steady walk stays steady up to the last frame.
/// @throws std::invalid_argument when the rate is not positive or would make more than 2^31 frames.
MotionClip Resample(const MotionClip& clip, double frame_rate_hz);

}  // namespace morphograph
