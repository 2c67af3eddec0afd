#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/contact_detector.h"
#include "primitives/keyframe_evaluation.h"
#include "primitives/keyframe_labels.h"

namespace morphograph::testing {

/// A recording with its reference key frames and contacts, in the frames of the imported clip.
struct LabelledClip {
  std::string path;  // below the data folder
  MotionClip clip;
  int dropped_frames = 0;
  std::vector<LabelledFrame> labels;           // as marked, in frames of the file
  std::vector<ReferenceKeyframe> reference;    // strikes; [first, last] is the double contact that follows
  std::vector<ContactInterval> contacts;
};

/// Reads `<set>_keyframes.json` and `<set>_contacts.json` ("cmu", "bnr", "neura_s02") and their clips.
inline std::vector<LabelledClip> ReadLabelledClips(const std::filesystem::path& data, const std::string& set) {
  const LabelledClips labels = ReadKeyframeLabels(data / "keyframes" / (set + "_keyframes.json"));
  std::ifstream file(data / "keyframes" / (set + "_contacts.json"));
  const nlohmann::json contacts = nlohmann::json::parse(file);
  std::vector<LabelledClip> clips;
  for (const auto& [path, frames] : labels) {
    LabelledClip labelled;
    labelled.path = path;
    labelled.labels = frames;
    ClipImportReport report;
    labelled.clip = ImportClip(ReadBvhFile(data / path), {}, &report);
    labelled.dropped_frames = report.dropped_frames;
    const int shift = report.dropped_frames;
    const nlohmann::json& entry = contacts.at(path);
    for (const Foot foot : {Foot::kLeft, Foot::kRight}) {
      for (const auto& interval : entry.at(std::string(FootName(foot)))) {
        labelled.contacts.push_back({foot, interval.at(0).get<int>() - shift, interval.at(1).get<int>() - shift});
      }
    }
    for (const LabelledFrame& frame : frames) {
      const std::vector<Keyframe> keyframe = ToKeyframes({frame}, shift, /*with_doubtful=*/true);
      if (keyframe.empty() || keyframe[0].label == KeyframeLabel::kStanding) continue;
      ReferenceKeyframe reference{keyframe[0].frame, keyframe[0].frame, keyframe[0].frame, keyframe[0].label,
                                  frame.doubtful};
      for (const auto& interval : entry.at("double")) {
        const double first = interval.at(0).get<int>() - shift;
        if (std::abs(first - reference.frame) <= 1) reference.last = interval.at(1).get<int>() - shift;
      }
      labelled.reference.push_back(reference);
    }
    clips.push_back(std::move(labelled));
  }
  return clips;
}

/// Tolerance of the reference strikes: 5 frames at 120 fps, 6 at 100, 2 at 30 (its README).
inline double StrikeToleranceS(double frame_rate_hz) {
  if (frame_rate_hz > 110) return 5.0 / 120;
  if (frame_rate_hz > 60) return 6.0 / 100;
  return 2.0 / 30;
}

/// The same reference without its double contacts: the strike alone counts.
inline std::vector<ReferenceKeyframe> StrikesOnly(std::vector<ReferenceKeyframe> reference) {
  for (ReferenceKeyframe& keyframe : reference) keyframe.first = keyframe.last = keyframe.frame;
  return reference;
}

inline const std::vector<KeyframeLabel>& StanceLabels() {
  static const std::vector<KeyframeLabel> labels = {KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance};
  return labels;
}

}  // namespace morphograph::testing
