#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "datasets/bvh_reader.h"
#include "datasets/manifest.h"
#include "datasets/motion_clip.h"

namespace morphograph {

/// What a set may hold, so that a stranger's stays cheap.
struct DatasetLimits {
  BvhLimits file;
  std::int64_t max_joint_frames = std::numeric_limits<std::int64_t>::max();  // joints x frames over all clips, 32 bytes each
};

/// A clip and where it comes from.
struct LoadedClip {
  MotionClip clip;             // `name` is the file stem, `style` as the manifest or the name says
  std::filesystem::path file;
  int first_frame = 0;         // frame of the file, from 0, that is the clip's first
  std::string note;            // what the import found worth saying, else empty
  std::string other_action = {};  // that it shows instead of the set's own (see OtherAction); else empty
};

/// A file that was left out on purpose.
struct SkippedClip {
  std::filesystem::path file;
  std::string reason;
};

struct Dataset {
  std::vector<LoadedClip> clips;     // in order of the paths given, files of a folder by name
  std::vector<SkippedClip> skipped;
  std::vector<std::string> notes;    // about the whole set
};

/// BVH files among `paths`: a file as it is, a folder searched to any depth for *.bvh (any case, hidden files left out), by name.
/// A file that is named twice comes once.
/// @throws DatasetError for a path that does not exist or cannot be searched, or when there is no file at all.
std::vector<std::filesystem::path> FindBvhFiles(const std::vector<std::filesystem::path>& paths);

/// Reads every clip of a set on up to `jobs` threads; the result does not depend on them.
///
/// Styles come from the manifest. Without a `style` pattern there, and when every file stem of the set has the form
/// `<anything>_<word>_<number>`, the word is the style ("dataset-2_walk_elderly_004"); else styles are empty.
/// @throws DatasetError with what is wrong with the first file that is broken, naming the others too, when nothing is left to use, or when the set is too large.
Dataset LoadDataset(const std::vector<std::filesystem::path>& paths, const DatasetManifest& manifest = DatasetManifest(),
                    int jobs = 1, const DatasetLimits& limits = {});

}  // namespace morphograph
