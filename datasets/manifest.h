#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/clip_conversion.h"

namespace morphograph {

/// What a manifest says of one clip. Frames count from 0 in the file, rest rows included; `to` is the last frame used.
struct ClipSelection {
  std::optional<int> from;
  std::optional<int> to;
  std::optional<std::string> style;
  bool exclude = false;
};

/// Describes a set of recordings: where they come from and what cannot be detected (or should be detected otherwise).
///
/// JSON, every field optional, unknown fields are errors:
/// ```json
/// {
///   "name": "bnr-walk", "action": "walk", "actions": {"run": ["*_run_*"]},
///   "source": "https://...", "licence": "CC BY-NC 4.0", "attribution": "(c) ...",
///   "metres_per_unit": 0.01, "up_axis": "Y", "roles": {"left_toe": "Toes_L"},
///   "style": "dataset-2_[a-z-]+_([a-z]+)_",
///   "include": ["walk*"], "exclude": ["*_033.bvh"],
///   "clips": {"06_02": {"from": 120, "to": 600, "style": "carrying"}, "06_07": {"exclude": true}},
///   "mirror": true, "bend": false,
///   "keyframes": "walking"
/// }
/// ```
/// `actions` names the files whose clips show another action than `action`: shell patterns as in `include`. `keyframes` is "walking", or a
/// `.json` file of labelled frames beside the manifest.
struct DatasetManifest {
  std::string name;
  std::string action = "walk";
  std::map<std::string, std::vector<std::string>> actions;  // of files that show another one, by shell patterns
  std::string source, licence, attribution;
  ClipImportOptions import;             // metres_per_unit, up_axis, roles
  std::string style_pattern;            // regular expression (RE2), searched in the file stem; group 1 is the style
  std::vector<std::string> include;     // shell patterns; empty takes all
  std::vector<std::string> exclude;
  std::map<std::string, ClipSelection> clips;  // by file stem
  bool mirror = false;                  // learn from left-right mirrored copies too
  bool bend = false;                    // learn from copies with a bent path too
  std::string keyframes = "walking";    // by feature; empty where labelled examples say what key frames are
  std::filesystem::path keyframe_examples;  // file of labels (keyframe_labels.h), relative to the manifest's folder; else empty
  std::string file;                     // the manifest's own name, for messages
};

/// @param file  name used in messages; `keyframes` ending in ".json" is taken relative to its folder.
/// @throws DatasetError naming the file and, by JSON pointer, the member.
DatasetManifest ParseManifest(std::string_view json, const std::string& file);
DatasetManifest ReadManifest(const std::filesystem::path& path);

/// Whether `include` and `exclude` let a file in. Patterns know `*`, `?` and `[...]` and are held against the file name and
/// against the path below the folder that was searched; `*` also matches `/`.
bool Includes(const DatasetManifest& manifest, const std::filesystem::path& relative_path);

/// The action that a file shows: one of `actions` whose patterns it fits (the first by name), else empty, for the action of the set.
std::string OtherAction(const DatasetManifest& manifest, const std::filesystem::path& relative_path);

}  // namespace morphograph
