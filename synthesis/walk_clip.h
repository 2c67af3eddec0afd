#pragma once

#include <vector>

#include "datasets/motion_clip.h"
#include "synthesis/synthesis_types.h"
#include "synthesis/synthesis_variant.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {

/// The motion of a drawn walk: steps laid out on the clip's frames, joined over their margins, planted feet locked, toes kept above the floor.
/// @param walk  one or more steps of one style, of one action or with made steps between them.
MotionClip MakeWalkClip(const MotionGraph& graph, const std::vector<DrawnStep>& walk, int frames, double frame_rate_hz,
                        const StartPose& start, const SynthesisVariant& variant = {});

}  // namespace morphograph
