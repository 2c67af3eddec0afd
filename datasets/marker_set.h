#pragma once

#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/placements.h"

namespace morphograph {

/// The 41 markers of a usual full-body set, as a capture studio glues them on: head (4), trunk (5), pelvis (4), arms (7 each) and legs (7 each).
///
/// Places are given by bone (a part of the way from a joint to the next) and by directions of the body (left, up, forwards) in the mean pose of the clips, then
/// fixed in the joint's frame, so that they do for skeletons whose axes lie anyhow. Markers whose joints the skeleton lacks are left out; sizes scale with the legs.
/// @throws std::invalid_argument when there are no clips, or a skeleton without leg roles.
std::vector<Placement> FullBodyMarkers(const std::vector<MotionClip>& clips);

}  // namespace morphograph
