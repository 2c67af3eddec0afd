#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/synthetic_gait.h"
#include "graph/graph_builder.h"

namespace morphograph::testing {

/// Synthetic walks, enough to learn a small model from without any recording: file stem (which says the style) and clip.
inline std::vector<std::pair<std::string, MotionClip>> SmallWalks() {
  std::vector<std::pair<std::string, MotionClip>> walks;
  int number = 0;
  for (const std::string style : {"brisk", "slow"}) {
    for (int i = 0; i < 6; ++i) {
      SyntheticGaitOptions options;
      options.seed = static_cast<std::uint64_t>(100 + number++);
      options.frame_rate_hz = 30;
      options.steps = 14;
      options.speed_m_s = style == "brisk" ? 1.5 : 0.9;
      options.left_first = i % 2 == 0;
      options.style = style;
      MotionClip clip = GenerateGait(options);
      clip.name = "walk_" + style + "_00" + std::to_string(i);
      clip.style = style;
      walks.emplace_back(clip.name, std::move(clip));
    }
  }
  return walks;
}

/// The walks as BVH text.
inline std::vector<std::pair<std::string, std::string>> SmallWalkFiles() {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& [name, clip] : SmallWalks()) files.emplace_back(name + ".bvh", WriteBvh(ExportClip(clip)));
  return files;
}

/// A model learned from SmallWalks(), once a process.
inline std::shared_ptr<const MotionGraph> SmallModel() {
  static const std::shared_ptr<const MotionGraph> model = [] {
    std::vector<TrainingClip> clips;
    for (auto& [name, clip] : SmallWalks()) clips.push_back({std::move(clip), true});
    TrainingOptions options;
    options.name = "walk";
    return BuildGraph(clips, options);
  }();
  return model;
}

/// The same with its recordings kept, which count as captured.
inline std::shared_ptr<const MotionGraph> SmallModelWithRecordings() {
  static const std::shared_ptr<const MotionGraph> model = [] {
    std::vector<TrainingClip> clips;
    for (auto& [name, clip] : SmallWalks()) clips.push_back({std::move(clip), false});
    TrainingOptions options;
    options.keep_recordings = true;
    return BuildGraph(clips, options);
  }();
  return model;
}

}  // namespace morphograph::testing
