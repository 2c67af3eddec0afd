#pragma once

#include "datasets/motion_clip.h"

namespace morphograph {

/// Number of frames at the start of a clip that show a rest pose and not the motion: frames with the root at
/// the origin without any turn (how converters fill missing rows), then a held pose from which the body jumps
/// into the motion (the T-pose row of many exporters). A clip that is nothing but rest counts none.
int CountLeadingRestFrames(const MotionClip& clip);

}  // namespace morphograph
