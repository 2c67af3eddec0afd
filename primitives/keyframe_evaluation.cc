#include "primitives/keyframe_evaluation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace morphograph {
namespace {

// Pairs of one label, both lists in time order. Where a pair is possible the first extracted goes to the allowed
// reference whose interval ends first: with intervals this greedy choice gives the most pairs.
void MatchLabel(const std::vector<double>& extracted, std::vector<ReferenceKeyframe> reference, double tolerance_frames,
                double rate, KeyframeScore* score) {
  std::stable_sort(reference.begin(), reference.end(),
                   [](const ReferenceKeyframe& a, const ReferenceKeyframe& b) { return a.last < b.last; });
  std::vector<char> used(reference.size(), 0);
  for (const double frame : extracted) {
    bool found = false;
    for (size_t i = 0; i < reference.size() && !found; ++i) {
      const ReferenceKeyframe& wanted = reference[i];
      if (used[i] || frame < wanted.first - tolerance_frames || frame > wanted.last + tolerance_frames) continue;
      used[i] = 1;
      found = true;
      if (wanted.doubtful) continue;
      ++score->true_positives;
      score->distortion_sum_s += std::abs(frame - wanted.frame) / rate;
    }
    if (!found) ++score->false_positives;
  }
  for (size_t i = 0; i < reference.size(); ++i) {
    if (!used[i] && !reference[i].doubtful) ++score->false_negatives;
  }
}

}  // namespace

double KeyframeScore::precision() const {
  const int extracted = true_positives + false_positives;
  return extracted > 0 ? static_cast<double>(true_positives) / extracted : 1;
}

double KeyframeScore::extraction_rate() const {
  const int wanted = true_positives + false_negatives;
  return wanted > 0 ? static_cast<double>(true_positives) / wanted : 1;
}

double KeyframeScore::distortion_s() const { return true_positives > 0 ? distortion_sum_s / true_positives : 0; }

KeyframeScore& KeyframeScore::operator+=(const KeyframeScore& other) {
  true_positives += other.true_positives;
  false_positives += other.false_positives;
  false_negatives += other.false_negatives;
  distortion_sum_s += other.distortion_sum_s;
  return *this;
}

KeyframeScore EvaluateKeyframes(const std::vector<Keyframe>& extracted, const std::vector<ReferenceKeyframe>& reference,
                                const std::vector<KeyframeLabel>& judged, double frame_rate_hz, double tolerance_s) {
  if (!(frame_rate_hz > 0) || !(tolerance_s >= 0)) {
    throw std::invalid_argument("EvaluateKeyframes: frame rate must be positive, tolerance not negative");
  }
  KeyframeScore score;
  for (const KeyframeLabel label : judged) {
    std::vector<double> frames;
    for (const Keyframe& keyframe : extracted) {
      if (keyframe.label == label) frames.push_back(keyframe.frame);
    }
    std::sort(frames.begin(), frames.end());
    std::vector<ReferenceKeyframe> wanted;
    std::copy_if(reference.begin(), reference.end(), std::back_inserter(wanted),
                 [label](const ReferenceKeyframe& keyframe) { return keyframe.label == label; });
    MatchLabel(frames, std::move(wanted), tolerance_s * frame_rate_hz, frame_rate_hz, &score);
  }
  return score;
}

}  // namespace morphograph
