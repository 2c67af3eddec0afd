#pragma once

#include <vector>

#include "datasets/motion_clip.h"
#include "graph/motion_graph.h"
#include "graph/recorded_motion.h"

namespace morphograph {

/// Clips to reconstruct from, and their steps.
struct MotionSource {
  std::vector<MotionClip> clips;
  std::vector<RecordedStep> steps;
};

/// The recordings that a model keeps; of one that keeps none, walks that it makes: some minutes of every style, always the same.
MotionSource SourceOf(const MotionGraph& graph, int jobs = 1);

}  // namespace morphograph
