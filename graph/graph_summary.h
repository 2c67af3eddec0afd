#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graph/action_change.h"
#include "graph/walk_boundary.h"
#include "primitives/keyframe.h"

namespace morphograph {

/// When a part of a foot is planted, in phase of the primitive (0 = first key frame, 1 = second).
struct ContactSummary {
  std::string part;  // "left_heel", "left_ball", "right_heel", "right_ball"
  double from_phase = 0;
  double to_phase = 0;
};

struct PrimitiveSummary {
  std::string name;   // "left_walk", "right_first_start", …
  std::string style;  // empty where the data has none
  std::string action;
  KeyframeLabel start = KeyframeLabel::kLeftStance;
  KeyframeLabel end = KeyframeLabel::kRightStance;
  int examples = 0;       // segments it was learned from
  int made_examples = 0;  // of these mirrored, bent or synthetic, not captured
  int components = 0;
  double variance_kept = 0;  // fraction, (0, 1]
  int mixture_size = 0;
  std::string covariance_form;  // "full", "tied" or "diagonal"
  double mean_duration_s = 0;
  std::vector<ContactSummary> contacts;
  bool dead_end = false;  // no transition leaves it
};

struct EdgeSummary {
  int from = 0;  // indices into `primitives`
  int to = 0;
  int pairs = 0;
  double probability = 0;  // empirical, of leaving `from` by this edge
  double length_scale = 0;
  double signal_variance = 0;
  double linear_variance = 0;
  double noise_variance = 0;
  double log_marginal_likelihood = 0;
  double unseen_error = 0;  // see TransitionModel
};

/// A made step from one action of a style into another, see ActionChange.
struct ChangeSummary {
  std::string name;
  std::string style;
  std::string from_action, to_action;
  int from = 0;  // indices into `primitives`
  int to = 0;
  int examples = 0;
  int near_examples = 0;
  ChangeEffort least, captured;
};

/// An action and the styles that show it.
struct ActionSummary {
  std::string name;
  std::vector<std::string> styles;
};

/// What `inspect` and `GET /v1/models/{name}` tell of a model.
struct GraphSummary {
  std::string name;
  std::string hash;    // content hash, hex
  std::string action;  // its own, that clips show unless another is asked for: "walk"
  std::vector<ActionSummary> actions;  // that one first
  int format_version = 0;
  int joints = 0;
  double frame_rate_hz = 0;
  double metres_per_unit = 0;
  int clips = 0;
  int frames = 0;
  std::string source;       // where the data came from
  std::string licence;      // and under which terms
  std::string attribution;  // text that must be kept, may be empty
  std::string command;      // that made the model, may be empty
  std::vector<std::string> styles;          // of its own action
  std::vector<StyleBoundaries> boundaries;  // how each style of each action can start and end
  std::vector<std::string> notes;  // what training could not learn, dead ends, …
  std::vector<PrimitiveSummary> primitives;
  std::vector<EdgeSummary> edges;
  std::vector<ChangeSummary> changes;
};

GraphSummary Summarise(const MotionGraph& graph);

}  // namespace morphograph
