#pragma once

#include <atomic>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "graph/motion_graph.h"
#include "graph/training_variant.h"
#include "primitives/keyframe.h"

namespace morphograph {

/// Thrown out of training when `TrainingOptions::cancelled` was set.
class TrainingCancelled : public std::runtime_error {
 public:
  TrainingCancelled() : std::runtime_error("training was cancelled") {}
};

/// Key frames of a clip, in time order.
using KeyframeFinder = std::function<std::vector<Keyframe>(const MotionClip&)>;

struct TrainingOptions {
  std::string name = "walk";
  std::string action = "walk";    // steps are called "<side>_<action>"
  /// Where steps of that action begin and end; by its features (KeyframeOptionsFor) when empty, so that only actions that are known
  /// there can be learned without it. Called from several threads.
  KeyframeFinder find_keyframes = {};
  bool keep_recordings = false;   // in the model, for reconstruction from sensors
  int jobs = 1;                   // threads; the result does not depend on it
  double variance_kept = 0.99;    // of the weighted PCA
  std::uint64_t seed = 1;         // of k-means++ starts
  TrainingVariant variant = {};   // for studies of what each part of the method is worth
  std::string source, licence, attribution, command;  // provenance, kept in the model
  std::function<void(const std::string& stage, double fraction)> progress;  // fraction of the whole, [0, 1]
  const std::atomic<bool>* cancelled = nullptr;
};

/// A clip to learn from, on a level floor at y = 0 (Augment puts it there); `made` marks mirrored, bent and synthetic ones.
struct TrainingClip {
  MotionClip clip;
  bool made = false;
  int source = -1;  // a number for the captured clip that a copy was made of, the same for all its copies; -1: none but itself
  std::string other_action = {};  // that it shows instead of `TrainingOptions::action`, found by its features; else empty
};

/// Learns a motion graph from clips (METHODS sections 1-3). Clips of another action become primitives of their own, beside those of the
/// graph's action, which they leave as they are.
/// @throws DatasetError when nothing can be learned (no leg roles, no two consecutive steps in any clip, an unknown action), saying
///   why and, where one clip is at fault, which; TrainingCancelled.
std::shared_ptr<const MotionGraph> BuildGraph(const std::vector<TrainingClip>& clips, const TrainingOptions& options);

}  // namespace morphograph
