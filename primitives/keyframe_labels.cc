#include "primitives/keyframe_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "datasets/errors.h"
#include "datasets/file_text.h"

namespace morphograph {
namespace {

using Json = nlohmann::json;

std::vector<LabelledFrame> ParseFrames(const Json& list, const std::string& clip, const std::string& source) {
  const std::string where = clip.empty() ? "key frames" : "clip '" + clip + "'";
  if (!list.is_array()) throw DatasetError(source, where + ": must be an array of {frame, label}");
  std::vector<LabelledFrame> frames;
  for (const Json& entry : list) {
    const std::string which = where + ", entry " + std::to_string(frames.size());
    if (!entry.is_object()) throw DatasetError(source, which + ": must be an object");
    const auto frame = entry.find("frame");
    const auto label = entry.find("label");
    if (frame == entry.end() || !frame->is_number()) throw DatasetError(source, which + ": 'frame' must be a number");
    const double at = std::round(frame->get<double>());
    if (!(at >= 0) || at > std::numeric_limits<int>::max()) {
      throw DatasetError(source, which + ": 'frame' must be between 0 and 2147483647");
    }
    if (label == entry.end() || !label->is_string() || label->get_ref<const std::string&>().empty()) {
      throw DatasetError(source, which + ": 'label' must be a text");
    }
    const auto doubtful = entry.find("doubtful");
    if (doubtful != entry.end() && !doubtful->is_boolean()) {
      throw DatasetError(source, which + ": 'doubtful' must be true or false");
    }
    frames.push_back({static_cast<int>(at), label->get<std::string>(), doubtful != entry.end() && doubtful->get<bool>()});
  }
  std::stable_sort(frames.begin(), frames.end(),
                   [](const LabelledFrame& a, const LabelledFrame& b) { return a.frame < b.frame; });
  return frames;
}

// A document this deep holds no labels; the bound keeps a hostile one from exhausting the stack.
constexpr int kMaxDepth = 8;

Json ParseJson(std::string_view text, const std::string& source) {
  try {
    return Json::parse(text, [&](int depth, Json::parse_event_t, Json&) {
      if (depth > kMaxDepth) throw DatasetError(source, "nested too deeply for key frame labels");
      return true;
    });
  } catch (const Json::parse_error& error) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    throw DatasetError(source, 1 + static_cast<int>(std::count(text.begin(), end, '\n')), 0, "not valid JSON");
  } catch (const Json::exception&) {
    throw DatasetError(source, "holds a number past the range of a double");
  }
}

}  // namespace

LabelledClips ParseKeyframeLabels(std::string_view json, const std::string& source) {
  const Json document = ParseJson(json, source);
  LabelledClips clips;
  if (document.is_array()) {
    clips[""] = ParseFrames(document, "", source);
    return clips;
  }
  if (!document.is_object()) throw DatasetError(source, "must be an object of clips or an array of {frame, label}");
  for (const auto& [clip, list] : document.items()) {
    const std::string name = document.size() == 1 && clip == "keyframes" ? "" : clip;
    clips[name] = ParseFrames(list, name, source);
  }
  return clips;
}

LabelledClips ReadKeyframeLabels(const std::filesystem::path& path) {
  return ParseKeyframeLabels(ReadFileText(path), path.string());
}

std::optional<KeyframeLabel> WalkingLabel(std::string_view name) {
  if (name == "left_strike") return KeyframeLabel::kLeftStance;
  if (name == "right_strike") return KeyframeLabel::kRightStance;
  if (name == "stand_begin" || name == "stand_end") return KeyframeLabel::kStanding;
  for (const KeyframeLabel label : {KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance,
                                    KeyframeLabel::kDoubleStance, KeyframeLabel::kStanding}) {
    if (name == KeyframeLabelName(label)) return label;
  }
  return std::nullopt;
}

std::vector<Keyframe> ToKeyframes(const std::vector<LabelledFrame>& labelled, int dropped_frames, bool with_doubtful) {
  std::vector<Keyframe> keyframes;
  for (const LabelledFrame& frame : labelled) {
    const std::optional<KeyframeLabel> label = WalkingLabel(frame.label);
    if (!label || frame.frame < dropped_frames || (frame.doubtful && !with_doubtful)) continue;
    keyframes.push_back({static_cast<double>(frame.frame - dropped_frames), *label});
  }
  return keyframes;
}

}  // namespace morphograph
