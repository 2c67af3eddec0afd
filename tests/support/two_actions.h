#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "graph/graph_builder.h"
#include "tests/support/small_model.h"

namespace morphograph::testing {

/// SmallWalks(), and half of them again as another action: their steps are then cut where running is cut, at the first contact.
inline std::vector<TrainingClip> ClipsOfTwoActions() {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : SmallWalks()) clips.push_back({std::move(clip), true});
  const size_t walks = clips.size();
  for (size_t i = 0; i < walks; ++i) {
    TrainingClip run = clips[i];
    if (run.clip.style != "brisk") continue;
    run.clip.name = "run_" + run.clip.name;
    run.other_action = "run";
    clips.push_back(std::move(run));
  }
  return clips;
}

/// A model learned from them, once a process.
inline std::shared_ptr<const MotionGraph> ModelOfTwoActions() {
  static const std::shared_ptr<const MotionGraph> model = [] {
    TrainingOptions options;
    options.name = "both";
    return BuildGraph(ClipsOfTwoActions(), options);
  }();
  return model;
}

}  // namespace morphograph::testing
