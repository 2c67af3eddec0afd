#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/motion_clip.h"
#include "graph/motion_graph.h"
#include "synthesis/step_track.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// A clip joined from steps, and what its steps know of the feet in every frame.
struct JoinedSteps {
  MotionClip clip;
  ContactProfile contacts;  // (kContactRows x frames)
};

/// Joins steps that follow each other into one clip of `frames` frames (METHODS section 3).
///
/// Neighbours are cross-faded over their shared margins in invariant channels: joint rotations, root height and tilt, and the root's
/// increments in its own heading frame, which are then integrated from `start`. So no step's pose is carried into the next.
/// @param tracks  in time order, each covering its cross-fades; the first starts at or before frame 0.
/// @param cross_fade  false: cut at the key frames, to compare with.
JoinedSteps JoinSteps(const MotionGraph& graph, const std::vector<StepTrack>& tracks, int frames, double frame_rate_hz,
                      const StartPose& start, bool cross_fade = true);

}  // namespace morphograph
