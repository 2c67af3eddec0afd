#include "api/keyframe_examples.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "primitives/learned_keyframes.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

std::string StemOf(const std::string& name) {
  std::string stem = fs::path(name).filename().string();
  for (const char* const extension : {".bvh", ".BVH"}) {
    if (stem.ends_with(extension)) stem.resize(stem.size() - 4);
  }
  return stem;
}

bool EndsWithPath(const fs::path& file, const fs::path& tail) {
  const std::string whole = "/" + file.generic_string(), end = "/" + tail.generic_string();
  return whole.ends_with(end) || whole.ends_with(end + ".bvh");
}

// Index of the clip that a name means, -1 for none.
int ClipOf(const std::string& name, const std::vector<LoadedClip>& clips, const std::string& source) {
  if (name.empty()) {  // a bare list: of the only clip
    if (clips.size() != 1) throw DatasetError(source, "does not say of which clip its labels are");
    return 0;
  }
  std::vector<int> of_stem, of_path;
  for (size_t i = 0; i < clips.size(); ++i) {
    if (clips[i].clip.name != StemOf(name)) continue;
    of_stem.push_back(static_cast<int>(i));
    if (EndsWithPath(clips[i].file, name)) of_path.push_back(static_cast<int>(i));
  }
  const std::vector<int>& meant = of_stem.size() > 1 ? of_path : of_stem;
  if (meant.size() > 1 || (meant.empty() && !of_stem.empty())) {
    throw DatasetError(source, "clip '" + name + "' may mean any of " + std::to_string(of_stem.size()) + " files");
  }
  return meant.empty() ? -1 : meant[0];
}

}  // namespace

MatchedLabels MatchLabels(const LabelledClips& labels, const std::vector<LoadedClip>& clips, const std::string& source) {
  MatchedLabels matched;
  matched.frames.resize(clips.size());
  int absent = 0;
  bool any = false;
  for (const auto& [name, frames] : labels) {
    const int index = ClipOf(name, clips, source);
    if (index < 0) {
      ++absent;
      continue;
    }
    const LoadedClip& loaded = clips[static_cast<size_t>(index)];
    for (LabelledFrame frame : frames) {
      frame.frame -= loaded.first_frame;
      if (frame.doubtful || frame.frame < 0 || frame.frame >= loaded.clip.frame_count()) continue;
      matched.frames[static_cast<size_t>(index)].push_back(frame);
      any = true;
    }
  }
  if (!any) throw DatasetError(source, "labels no frame of any clip in use");
  if (absent > 0) {
    matched.notes.push_back("labels of " + std::to_string(absent) + " clip" + (absent > 1 ? "s" : "") + " that " +
                            (absent > 1 ? "are" : "is") + " not in use are left out");
  }
  return matched;
}

KeyframeFinder LearnKeyframes(const std::vector<MotionClip>& clips, const std::vector<std::vector<LabelledFrame>>& frames,
                              const std::string& source) {
  std::vector<KeyframeExamples> examples;
  bool walking = false;
  for (size_t i = 0; i < clips.size(); ++i) {
    if (frames[i].empty()) continue;
    examples.push_back({&clips[i], frames[i]});
    walking |= std::any_of(frames[i].begin(), frames[i].end(), [](const LabelledFrame& f) { return WalkingLabel(f.label).has_value(); });
  }
  if (!walking) throw DatasetError(source, "none of its labels says where a step begins (left_stance, right_stance, ...)");
  try {
    const auto detector = std::make_shared<const LearnedKeyframeDetector>(examples);
    return [detector](const MotionClip& clip) { return WalkingKeyframes(detector->Detect(clip)); };
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(source, ReasonOf(unfit));
  }
}

}  // namespace morphograph
