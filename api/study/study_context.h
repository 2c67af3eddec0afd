#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datasets/augmentation.h"
#include "datasets/dataset_loader.h"
#include "datasets/noise_model.h"
#include "graph/graph_builder.h"
#include "graph/motion_graph.h"
#include "primitives/keyframe_labels.h"

namespace morphograph {

struct StudyOptions {
  bool quick = false;      // few clips, seeds and repetitions: shows that everything runs, its figures mean little
  int jobs = 1;            // threads; no figure depends on them
  std::uint64_t seed = 1;  // of noise, halves, samples and forests
  NoiseOptions noise;
  AugmentationOptions augmentation;     // copies that models learn from too, as the manifest says
  std::string action = "walk";          // what models learn
  KeyframeFinder find_keyframes = {};   // where steps begin, for models; by the features of the action when empty
  std::function<void(const std::string& stage, double fraction)> progress = {};  // of the section at hand, [0, 1]
};

/// `count` of the values at even distances, or all when they are no more.
template <typename T>
std::vector<T> SpreadOver(const std::vector<T>& values, size_t count) {
  if (values.size() <= count) return values;
  std::vector<T> some;
  for (size_t i = 0; i < count; ++i) some.push_back(values[i * values.size() / count]);
  return some;
}

enum class StudyData { kClean, kNoisy };

/// What every part of the study works on: the captured clips, the same with noise, and models learned from them, each made once. For one
/// thread, which may use `options().jobs` of them.
class StudyContext {
 public:
  /// @param clips  captured, as loaded; @param labels  of their key frames, may be empty.
  /// @throws DatasetError naming a clip that cannot be studied (no leg roles, fewer than two frames), or when there is none.
  StudyContext(std::vector<LoadedClip> clips, LabelledClips labels, StudyOptions options);

  const StudyOptions& options() const { return options_; }
  const LabelledClips& labels() const { return labels_; }
  /// Clips as they were loaded, one a recording, with the first frame of the file that each begins with.
  const std::vector<LoadedClip>& loaded() const { return loaded_; }
  /// The same clips on a level floor (as training sees them); noisy ones have the noise of the options.
  const std::vector<MotionClip>& clips(StudyData data) const;
  /// The skeleton of the first clip, which every model of the study draws on, whatever clips it is learned from.
  const std::shared_ptr<const Skeleton>& body() const { return loaded_.front().clip.shared_skeleton(); }
  /// Names of the styles, sorted; one empty name where the data has none.
  const std::vector<std::string>& styles() const { return styles_; }

  /// Learned from all clips.
  std::shared_ptr<const MotionGraph> Model(StudyData data);
  /// Options of training with the action and the threads of the study, and its finder of key frames unless they bring one.
  TrainingOptions Training(TrainingOptions options = {}) const;
  /// Learned from some clips, by position, under other options than the usual ones; not kept. @throws DatasetError when nothing can be
  /// learned from them.
  std::shared_ptr<const MotionGraph> Learn(StudyData data, const std::vector<int>& which, const TrainingOptions& options = {});

  /// Clip positions in two halves, each ascending.
  using Halves = std::array<std::vector<int>, 2>;
  /// Style by style, drawn by the seed: the same split for every part of the study.
  const std::vector<int>& half(int which) const { return halves_[static_cast<size_t>(which)]; }
  /// More such splits, by number; number 0 is that one.
  Halves Halving(int number) const;

 private:
  std::vector<MotionClip> Captured(StudyData data, const std::vector<int>& which) const;  // on the floor they were captured on

  StudyOptions options_;
  LabelledClips labels_;
  std::vector<LoadedClip> loaded_;
  std::vector<MotionClip> clips_[2];
  std::vector<std::string> styles_;
  Halves halves_;
  std::shared_ptr<const MotionGraph> models_[2];
};

}  // namespace morphograph
