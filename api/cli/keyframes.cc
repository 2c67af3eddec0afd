#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/cli/command.h"
#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "primitives/keyframe_detector.h"
#include "primitives/keyframe_labels.h"
#include "primitives/learned_keyframes.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

struct KeyframesFlags {
  std::string clip, labels, method = "feature", action = "walk";
  bool json = false;
};

struct FoundKeyframe {
  double frame = 0;  // of the imported clip
  std::string label;
};

// The clip that a labels file speaks of: its name is a path below the labels' folder or the one above, or the stem of a
// file beside the labels or beside the clip that is searched. Empty when it is nowhere.
fs::path ExampleFile(const std::string& name, const fs::path& labels, const fs::path& searched) {
  const fs::path folder = fs::absolute(labels).parent_path();
  for (const fs::path& base : {folder, folder.parent_path(), fs::absolute(searched).parent_path()}) {
    for (const fs::path& file : {base / name, base / (name + ".bvh")})
      if (fs::is_regular_file(file)) return file;
  }
  return {};
}

// CONTRACT.md's names for walking; labels of other actions as they were written.
std::string ContractLabel(const std::string& written) {
  const std::vector<Keyframe> known = ToKeyframes({{0, written, false}}, 0);
  return known.empty() ? written : std::string(KeyframeLabelName(known[0].label));
}

std::vector<FoundKeyframe> LearnedKeyframes(const MotionClip& clip, const KeyframesFlags& flags) {
  const LabelledClips labels = ReadKeyframeLabels(flags.labels);
  std::vector<MotionClip> clips;
  std::vector<std::vector<LabelledFrame>> frames;
  clips.reserve(labels.size());
  for (const auto& [name, labelled] : labels) {
    const fs::path file = ExampleFile(name, flags.labels, flags.clip);
    // Its own labels would answer for the clip, so they are left out.
    if (file.empty() || fs::equivalent(file, flags.clip)) continue;
    ClipImportReport import;
    clips.push_back(ImportClip(ReadBvhFile(file), {}, &import));
    frames.emplace_back();
    for (LabelledFrame frame : labelled) {
      frame.frame -= import.dropped_frames;
      if (frame.frame >= 0 && !frame.doubtful) frames.back().push_back(frame);
    }
  }
  if (clips.empty()) throw DatasetError(flags.labels, "none of the clips that it names, other than the one searched, is there");
  std::vector<KeyframeExamples> examples;
  for (std::size_t i = 0; i < clips.size(); ++i) examples.push_back({&clips[i], frames[i]});
  std::vector<FoundKeyframe> found;
  for (const LearnedKeyframe& keyframe : LearnedKeyframeDetector(examples).Detect(clip))
    found.push_back({keyframe.frame, ContractLabel(keyframe.label)});
  return found;
}

std::vector<FoundKeyframe> FeatureKeyframes(const MotionClip& clip, const KeyframesFlags& flags) {
  std::vector<FoundKeyframe> found;
  for (const Keyframe& keyframe : DetectKeyframes(clip, KeyframeOptionsFor(flags.action)))
    found.push_back({keyframe.frame, std::string(KeyframeLabelName(keyframe.label))});
  return found;
}

void Keyframes(const KeyframesFlags& flags) {
  const bool learned = flags.method == "learned";
  if (learned && flags.labels.empty()) throw UsageError("keyframes: --method learned needs --labels");
  ClipImportReport import;
  const MotionClip clip = ImportClip(ReadBvhFile(flags.clip), {}, &import);
  std::vector<FoundKeyframe> keyframes;
  try {
    keyframes = learned ? LearnedKeyframes(clip, flags) : FeatureKeyframes(clip, flags);
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(flags.clip, ReasonOf(unfit));
  }
  // Frames count as in the file, leading rest rows included.
  const auto frame_in_file = [&](const FoundKeyframe& keyframe) {
    return static_cast<int>(std::lround(keyframe.frame)) + import.dropped_frames;
  };
  if (flags.json) {
    nlohmann::ordered_json json = {{"keyframes", nlohmann::ordered_json::array()}};
    for (const FoundKeyframe& keyframe : keyframes)
      json["keyframes"].push_back({{"frame", frame_in_file(keyframe)}, {"label", keyframe.label}});
    std::cout << json.dump() << '\n';
  } else {
    for (const FoundKeyframe& keyframe : keyframes) std::cout << frame_in_file(keyframe) << '\t' << keyframe.label << '\n';
  }
}

}  // namespace

void AddKeyframes(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<KeyframesFlags>();
  CLI::App* verb = program->add_subcommand("keyframes", "Find the key frames of a clip");
  verb->add_option("clip", flags->clip, "BVH file")->required();
  verb->add_option("--method", flags->method, "feature, or learned from --labels")
      ->check(CLI::IsMember({"feature", "learned"}))->capture_default_str();
  verb->add_option("--labels", flags->labels, "Labelled frames, JSON");
  verb->add_option("--action", flags->action, "walk or run")->check(CLI::IsMember({"walk", "run"}))->capture_default_str();
  verb->add_flag("--json", flags->json, "As JSON");
  verb->callback([flags, work] { *work = [flags] { Keyframes(*flags); }; });
}

}  // namespace morphograph
