#pragma once

#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// Captured clips as they are held against synthesised ones: without `frames` at both ends, where recordings set off and slow down while
/// synthesised clips are cut out of a walk. Clips of which less than a second would be left are dropped, no others: whoever measures longer
/// pieces passes over what is shorter anyway, and windows of half a second are too few to drop any. @param clips  at 30 fps.
std::vector<MotionClip> WithoutEnds(const std::vector<MotionClip>& clips, int frames = 30);

}  // namespace morphograph
