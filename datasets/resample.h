#pragma once

#include <cstdint>

#include "datasets/motion_clip.h"

namespace morphograph {

/// Largest result of Resample() unless it is told otherwise: joints x frames.
inline constexpr std::int64_t kMaxResampledJointFrames = 60'000'000;

/// The clip at another frame rate, from the first frame to at most the last; frames that fall on source frames when the
/// rate rises are those frames.
///
/// When the rate rises, positions run along Catmull-Rom cubics and rotations do so in the tangent space of the
/// frame before. When it falls, each output frame is the mean of the frames around it, weighted by a windowed sinc that
/// passes what the lower rate can hold (linear, zero phase; rotations again averaged in a tangent space). The ends
/// are continued by point reflection, so that a steady walk stays steady up to the last frame.
/// @throws std::invalid_argument when the rate is not positive, or the result would hold more than `max_joint_frames` rotations
///   (32 bytes each): a slow clip becomes many times its size.
MotionClip Resample(const MotionClip& clip, double frame_rate_hz,
                    std::int64_t max_joint_frames = kMaxResampledJointFrames);

/// The same frames at another frame rate: the clip played faster or slower.
/// @throws std::invalid_argument when the rate is not positive.
MotionClip Retimed(const MotionClip& clip, double frame_rate_hz);

/// The clip played backwards.
MotionClip Reversed(const MotionClip& clip);

}  // namespace morphograph
