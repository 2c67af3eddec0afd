#pragma once

#include "datasets/motion_clip.h"
#include "graph/motion_graph.h"
#include "synthesis/evaluation.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {

/// What is to be said of a walk over the graph and its clip: steps with their likelihood, contacts, path and quality.
/// @param evaluation  of the clip, where it is known already.
SynthesisReport DescribeWalk(const MotionGraph& graph, const DrawnWalk& walk, const MotionClip& clip, const ClipEvaluation* evaluation = nullptr);

}  // namespace morphograph
