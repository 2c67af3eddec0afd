#pragma once

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/synthetic_gait.h"
#include "graph/graph_builder.h"
#include "graph/model_io.h"

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

inline constexpr const char* kSmallModelFile = "small.mgm";
inline constexpr const char* kSmallModelWithRecordingsFile = "small_with_recordings.mgm";

inline std::shared_ptr<const MotionGraph> LearnSmallModel() {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : SmallWalks()) clips.push_back({std::move(clip), true});
  TrainingOptions options;
  options.name = "walk";
  return BuildGraph(clips, options);
}

inline std::shared_ptr<const MotionGraph> LearnSmallModelWithRecordings() {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : SmallWalks()) clips.push_back({std::move(clip), false});
  TrainingOptions options;
  options.keep_recordings = true;
  return BuildGraph(clips, options);
}

/// The model of that file where ctest has had it made for this run (small_model_maker), else learned now.
inline std::shared_ptr<const MotionGraph> MadeOrLearned(const char* file, std::shared_ptr<const MotionGraph> (*learn)()) {
  const char* folder = std::getenv("MORPHOGRAPH_SMALL_MODELS");
  return folder ? LoadModel(std::filesystem::path(folder) / file) : learn();
}

/// A model learned from SmallWalks(), once a process at most.
inline std::shared_ptr<const MotionGraph> SmallModel() {
  static const std::shared_ptr<const MotionGraph> model = MadeOrLearned(kSmallModelFile, LearnSmallModel);
  return model;
}

/// The same with its recordings kept, which count as captured.
inline std::shared_ptr<const MotionGraph> SmallModelWithRecordings() {
  static const std::shared_ptr<const MotionGraph> model = MadeOrLearned(kSmallModelWithRecordingsFile, LearnSmallModelWithRecordings);
  return model;
}

}  // namespace morphograph::testing
