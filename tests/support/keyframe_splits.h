#pragma once

#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "primitives/learned_keyframes.h"
#include "tests/support/labelled_clips.h"

namespace morphograph::testing {

/// Which of the labelled clips teach a detector and which ones it is judged on.
struct KeyframeFold {
  std::vector<size_t> teach, judge;
};

/// Both ways of a split: each half teaches the other.
inline std::vector<KeyframeFold> BothWays(std::vector<size_t> one, std::vector<size_t> other) {
  return {{one, other}, {other, one}};
}

/// The clips in turn to the one half and to the other.
inline std::vector<KeyframeFold> AlternateHalves(size_t clips) {
  std::vector<size_t> halves[2];
  for (size_t i = 0; i < clips; ++i) halves[i % 2].push_back(i);
  return BothWays(halves[0], halves[1]);
}

/// Halves drawn at random.
inline std::vector<KeyframeFold> RandomHalves(size_t clips, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<size_t> order(clips);
  std::iota(order.begin(), order.end(), size_t{0});
  for (size_t i = clips; i > 1; --i) {  // std::shuffle differs between libraries
    std::swap(order[i - 1], order[boost::random::uniform_int_distribution<size_t>(0, i - 1)(rng)]);
  }
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(clips / 2);
  return BothWays({order.begin(), middle}, {middle, order.end()});
}

/// Who walks, or how: the last but one part of the file's name, the subject in "07_01", the style in "dataset-2_walk_normal_001".
inline std::string GroupOf(const LabelledClip& clip) {
  const std::string name = std::filesystem::path(clip.path).stem().string();
  const size_t end = name.rfind('_');
  if (end == std::string::npos || end == 0) return name;
  const size_t before = name.rfind('_', end - 1);
  const size_t begin = before == std::string::npos ? 0 : before + 1;
  return name.substr(begin, end - begin);
}

/// Every group judged by a detector that has seen all the others and nothing of it.
inline std::vector<KeyframeFold> LeaveGroupsOut(const std::vector<LabelledClip>& clips) {
  std::map<std::string, KeyframeFold> folds;
  for (const LabelledClip& clip : clips) folds[GroupOf(clip)];
  for (size_t i = 0; i < clips.size(); ++i) {
    for (auto& [group, fold] : folds) (GroupOf(clips[i]) == group ? fold.judge : fold.teach).push_back(i);
  }
  std::vector<KeyframeFold> list;
  for (const auto& [group, fold] : folds) list.push_back(fold);
  return list;
}

/// The strikes of a clip as examples, in its own frames.
inline KeyframeExamples StrikeExamples(const LabelledClip& labelled) {
  KeyframeExamples examples{&labelled.clip, labelled.labels};
  std::erase_if(examples.labels, [](const LabelledFrame& label) { return !label.label.ends_with("_strike"); });
  for (LabelledFrame& label : examples.labels) label.frame -= labelled.dropped_frames;
  return examples;
}

inline KeyframeScore JudgeKeyframes(const std::vector<Keyframe>& found, const LabelledClip& clip) {
  const double rate = clip.clip.frame_rate_hz();
  return EvaluateKeyframes(found, clip.reference, StanceLabels(), rate, StrikeToleranceS(rate));
}

/// Sum over the folds.
inline KeyframeScore JudgeLearned(const std::vector<LabelledClip>& clips, const std::vector<KeyframeFold>& folds) {
  KeyframeScore score;
  for (const KeyframeFold& fold : folds) {
    std::vector<KeyframeExamples> examples;
    for (const size_t i : fold.teach) examples.push_back(StrikeExamples(clips[i]));
    const LearnedKeyframeDetector detector(examples);
    for (const size_t i : fold.judge) score += JudgeKeyframes(WalkingKeyframes(detector.Detect(clips[i].clip)), clips[i]);
  }
  return score;
}

}  // namespace morphograph::testing
