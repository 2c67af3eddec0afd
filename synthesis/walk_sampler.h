#pragma once

#include <optional>
#include <random>
#include <vector>

#include "graph/motion_graph.h"
#include "graph/walk_boundary.h"
#include "synthesis/graph_walk.h"

namespace morphograph {

/// From some time on a walk shows another action of its style.
struct StyleChange {
  double at_s = 0;
  int style = 0;  // of the graph's styles, its entry for that action
};

/// What kind of walk to draw.
struct WalkExtent {
  int style = 0;  // of the graph's styles
  WalkBoundary from = WalkBoundary::kWalking;
  WalkBoundary to = WalkBoundary::kWalking;
  std::optional<int> steps;  // of the whole walk, start and end included
  double duration_s = 5;     // where `steps` is empty
  double frame_rate_hz = 30;
  std::vector<StyleChange> changes = {};  // in time order; a walk that changes has a duration, no number of steps
};

/// A step of a walk on the clip's time line; times in frames, fractional.
struct DrawnStep {
  WalkStep step;
  StepShape shape;
  double start = 0;
  double end = 0;
  std::optional<ContactProfile> contacts = {};  // of a made step; others have those that their latent tells
};

struct DrawnWalk {
  std::vector<DrawnStep> steps;
  int frames = 0;
};

/// Draws a legal walk over the graph from one boundary to the other.
///
/// Inside a walk a clip is cut at frame 0 and where its time is over; a walk that starts or ends does so with the margin of its
/// first or last step, in which the body stands. `steps` are met exactly. A duration is met to the frame where the walk goes on at
/// its end; where it stops, the walk goes on until the time is over, then the step to stop after is the one with which the whole comes nearest
/// to the duration. So a longer duration walks on from the same first steps.
///
/// A change of action comes with the step that begins nearest to its time, or up to six steps later: whether steps of two actions are near
/// enough to make one of them (ActionChange) is a matter of the walk, and walks are drawn until it is so.
/// @throws UnsatisfiableRequest when the style has no such start ("/start/from") or end ("/end"), no walk has that many steps, or none that
///   was drawn could change its action ("/actions/1").
DrawnWalk DrawWalk(const MotionGraph& graph, const WalkExtent& extent, std::mt19937_64& rng);

}  // namespace morphograph
