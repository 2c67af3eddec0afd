#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "primitives/keyframe.h"

namespace morphograph {

/// A key frame that somebody marked in a clip.
struct LabelledFrame {
  int frame = 0;      // counts from 0 in the file, leading rest rows included
  std::string label;  // as written, e.g. "left_strike" or any label of another action
  bool doubtful = false;
};

/// Labelled frames of each clip, by the clip's name as written (a path or a file stem).
using LabelledClips = std::map<std::string, std::vector<LabelledFrame>>;

/// Parses {clip: [{"frame", "label", "doubtful"?}]}, or {"keyframes": [...]} or a bare array for one clip, which is then
/// named "". The frames of each clip come back in time order.
/// @param source  name used in messages.
/// @throws DatasetError with the line where the JSON is broken or naming the clip and the entry that is wrong.
LabelledClips ParseKeyframeLabels(std::string_view json, const std::string& source);

/// Reads and parses a file. @throws DatasetError also when it cannot be read.
LabelledClips ReadKeyframeLabels(const std::filesystem::path& path);

/// The walking key frame that a label means: "left_strike" and "right_strike" are stances, "stand_begin" and "stand_end"
/// are standing; the names of KeyframeLabelName are taken too. Nothing for labels of other actions.
std::optional<KeyframeLabel> WalkingLabel(std::string_view name);

/// Key frames in the frames of a clip that dropped `dropped_frames` leading rows. Frames that were
/// dropped and labels that WalkingLabel does not know are left out; doubtful ones too unless asked for.
std::vector<Keyframe> ToKeyframes(const std::vector<LabelledFrame>& labelled, int dropped_frames,
                                  bool with_doubtful = false);

}  // namespace morphograph
