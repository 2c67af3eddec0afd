#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// What `morphograph study` asks for.
struct StudyRequest {
  std::vector<std::filesystem::path> data;  // files and folders
  std::optional<std::filesystem::path> manifest;
  std::vector<std::filesystem::path> labels;  // of key frames; empty: every *keyframes*.json below the folders of `data`
  StudyOptions options;                       // `augmentation`, `action` and `find_keyframes` come from the manifest
};

/// Clips of one style that were studied.
struct StudiedStyle {
  std::string name;
  int clips = 0;
  std::int64_t frames = 0;
  double duration_s = 0;
};

/// What the study found, and of what.
struct StudyReport {
  bool quick = false;
  std::uint64_t seed = 1;
  NoiseOptions noise;
  std::vector<std::string> data;  // last parts of the paths that were given
  int clips_read = 0;             // a quick study takes some of them
  std::vector<StudiedStyle> styles;
  int labelled_clips = 0;
  std::vector<std::string> notes;  // files left out, parts that could not be done
  std::vector<StudySection> sections;
  int jobs = 1;
  std::vector<std::pair<std::string, double>> times_s;  // of each part, in order
};

/// Runs the published evaluation on a set of recordings: key frames, alignment, reduction, mixture, transitions, samples, ablations.
///
/// A section that cannot be done on these data says so in its place. Only times depend on `jobs`.
/// @throws TrainingUsageError or DatasetError when the clips cannot be read or no model can be learned from them.
StudyReport RunStudy(const StudyRequest& request);

}  // namespace morphograph
