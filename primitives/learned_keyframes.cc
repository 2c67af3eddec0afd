#include "primitives/learned_keyframes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "primitives/frame_distance.h"
#include "primitives/pose_window.h"

namespace morphograph {
namespace {

// A minimum of the distance that is not half as deep as the distance is high around it is no key frame.
constexpr double kShallow = 0.5;

// "left" for "right" and the other way round; empty where the label names no side.
std::string OtherSide(const std::string& label) {
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"left", "right"}, {"right", "left"}}) {
    const size_t at = label.find(from);
    if (at != std::string::npos) return std::string(label).replace(at, from.size(), to);
  }
  return {};
}

}  // namespace

LearnedKeyframeDetector::LearnedKeyframeDetector(const std::vector<KeyframeExamples>& examples,
                                                 const LearnedKeyframeOptions& options)
    : options_(options) {
  std::vector<Lesson> lessons;
  std::set<std::string> labels;
  for (size_t c = 0; c < examples.size(); ++c) {
    const MotionClip& clip = *examples[c].clip;
    Lesson lesson{static_cast<int>(c), Measure(ScaledPoses(clip), clip.frame_rate_hz()), {}};
    for (const LabelledFrame& labelled : examples[c].labels) {
      if (labelled.frame < 0 || labelled.frame >= clip.frame_count() || labelled.doubtful) continue;
      lesson.frames[labelled.label].push_back(labelled.frame);
      labels.insert(labelled.label);
    }
    lessons.push_back(std::move(lesson));
  }
  if (labels.empty()) throw std::invalid_argument("LearnedKeyframeDetector: no labelled frame in any example clip");
  for (size_t c = 0; c < examples.size(); ++c) {
    std::map<std::string, std::vector<double>> swapped;
    for (const auto& [label, frames] : lessons[c].frames) {
      // A side that nobody marked may be meant to stay unmarked.
      const std::string other = OtherSide(label);
      if (labels.count(other)) swapped[other] = frames;
    }
    if (swapped.empty()) continue;
    lessons.push_back({lessons[c].clip, Measure(MirroredPoses(lessons[c].features.poses), lessons[c].features.rate_hz), swapped});
  }
  SetKinds(lessons);
  SetWeights(lessons);
  SetThreshold(examples, lessons);
}

LearnedKeyframeDetector::Features LearnedKeyframeDetector::Measure(std::vector<Eigen::Matrix3Xd> poses, double rate_hz) {
  Features features{rate_hz, std::move(poses), {}};
  features.signals = CueSignals(features.poses, rate_hz);
  return features;
}

void LearnedKeyframeDetector::SetKinds(const std::vector<Lesson>& lessons) {
  std::map<std::string, Kind> kinds;
  std::map<std::string, std::vector<CueExample>> cue_examples;
  for (const Lesson& lesson : lessons) {
    const double rate = lesson.features.rate_hz;
    for (const auto& [label, frames] : lesson.frames) {
      Kind& kind = kinds[label];
      if (kind.label.empty()) kind.spacing_s = std::numeric_limits<double>::infinity();
      kind.label = label;
      for (size_t i = 0; i < frames.size(); ++i) {
        kind.examples.push_back(PoseWindow(lesson.features.poses, frames[i], options_.window_s * rate));
        kind.clips.push_back(lesson.clip);
        if (i > 0) kind.spacing_s = std::min(kind.spacing_s, options_.spacing * (frames[i] - frames[i - 1]) / rate);
      }
      cue_examples[label].push_back({&lesson.features.signals, rate, frames});
    }
  }
  for (auto& [label, kind] : kinds) {
    if (!std::isfinite(kind.spacing_s)) kind.spacing_s = 0;
    kind.cues = LearnTimingCues(cue_examples[label], options_.cue_reach_s, options_.cues);
    kinds_.push_back(std::move(kind));
  }
}

void LearnedKeyframeDetector::SetWeights(const std::vector<Lesson>& lessons) {
  std::vector<Eigen::Matrix3Xd> all;
  for (const Lesson& lesson : lessons) {
    const Features& clip = lesson.features;
    const double stride = std::max(1.0, clip.rate_hz / options_.search_rate_hz);
    for (double frame = 0; frame < static_cast<double>(clip.poses.size()); frame += stride) {
      all.push_back(PoseWindow(clip.poses, frame, options_.window_s * clip.rate_hz));
    }
  }
  std::vector<std::vector<Eigen::Matrix3Xd>> kinds;
  for (const Kind& kind : kinds_) kinds.push_back(kind.examples);
  weights_ = DiscriminantWeights(kinds, all);
}

std::vector<LearnedKeyframeDetector::Candidate> LearnedKeyframeDetector::Candidates(const Features& clip,
                                                                                    int without_clip) const {
  if (clip.poses.empty()) return {};
  const double rate_hz = clip.rate_hz;
  const double reach = options_.window_s * rate_hz;
  const double last = static_cast<double>(clip.poses.size()) - 1;
  const double stride = std::max(1.0, rate_hz / options_.search_rate_hz);
  std::vector<Eigen::Matrix3Xd> windows;
  for (double frame = 0; frame <= last; frame += stride) windows.push_back(PoseWindow(clip.poses, frame, reach));
  const int count = static_cast<int>(windows.size());
  const int kinds = static_cast<int>(kinds_.size());

  Eigen::MatrixXd nearest = Eigen::MatrixXd::Constant(kinds, count, std::numeric_limits<double>::infinity());
  for (int k = 0; k < kinds; ++k) {
    std::vector<Eigen::Matrix3Xd> used;
    for (size_t e = 0; e < kinds_[k].examples.size(); ++e) {
      if (kinds_[k].clips[e] != without_clip) used.push_back(kinds_[k].examples[e]);
    }
    if (!used.empty()) nearest.row(k) = FrameDistanceMatrix(used, windows, weights_).colwise().minCoeff();
  }

  std::vector<Candidate> candidates;
  for (int k = 0; k < kinds; ++k) {
    const auto row = nearest.row(k);
    const double around_s = kinds_[k].spacing_s > 0 ? kinds_[k].spacing_s / options_.spacing : last / rate_hz;
    const int around = static_cast<int>(std::ceil(around_s * rate_hz / stride));
    for (int i = 1; i + 1 < count; ++i) {
      if (!std::isfinite(row[i]) || !(row[i] < row[i - 1]) || !(row[i] <= row[i + 1])) continue;
      if (nearest.col(i).minCoeff() < row[i]) continue;
      const double shift = 0.5 * (row[i - 1] - row[i + 1]) / (row[i - 1] - 2 * row[i] + row[i + 1]);  // vertex of a parabola
      const int from = std::max(0, i - around), to = std::min(count - 1, i + around);
      candidates.push_back({(i + shift) * stride, k, row[i] / row.segment(from, to - from + 1).maxCoeff()});
    }
  }
  DropCrowded(rate_hz, &candidates);
  for (Candidate& candidate : candidates) {
    const std::optional<double> refined =
        RefineByCues(kinds_[candidate.kind].cues, clip.signals, rate_hz, candidate.frame, options_.cue_reach_s);
    if (refined) candidate.frame = *refined;
  }
  // A key frame shows more in what follows it than in what comes before.
  std::erase_if(candidates, [&](const Candidate& candidate) {
    return candidate.frame < 0.5 * reach || candidate.frame > last - std::max(reach, options_.min_seen_s * rate_hz);
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.frame < b.frame; });
  return candidates;
}

// Of two of a kind that are too close the nearer to the examples stays.
void LearnedKeyframeDetector::DropCrowded(double rate_hz, std::vector<Candidate>* candidates) const {
  std::stable_sort(candidates->begin(), candidates->end(),
                   [](const Candidate& a, const Candidate& b) { return a.depth < b.depth; });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : *candidates) {
    const double spacing = kinds_[candidate.kind].spacing_s * rate_hz;
    const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return other.kind == candidate.kind && std::abs(other.frame - candidate.frame) < spacing;
    });
    if (!crowded) kept.push_back(candidate);
  }
  *candidates = std::move(kept);
}

// Whether a candidate that is no key frame shows how unlike key frames others may be. One beside a label of its kind is like enough,
// only late or early; and near an end of the clip there may be one that nobody marked, as of a foot that already stood there.
bool LearnedKeyframeDetector::TeachesThreshold(const Candidate& wrong, const KeyframeExamples& example) const {
  const double near = kinds_[wrong.kind].spacing_s * example.clip->frame_rate_hz();
  if (wrong.frame < near || wrong.frame > example.clip->frame_count() - 1 - near) return false;
  return std::none_of(example.labels.begin(), example.labels.end(), [&](const LabelledFrame& labelled) {
    return labelled.label == kinds_[wrong.kind].label && std::abs(labelled.frame - wrong.frame) < near;
  });
}

void LearnedKeyframeDetector::SetThreshold(const std::vector<KeyframeExamples>& examples, const std::vector<Lesson>& lessons) {
  const bool several = std::any_of(examples.begin() + 1, examples.end(),
                                   [](const KeyframeExamples& clip) { return !clip.labels.empty(); });
  if (!several) {
    // One clip cannot be judged by others: every example would find itself.
    threshold_ = 0.5 * kShallow;
    return;
  }
  std::vector<std::pair<double, bool>> judged;  // depth, is a key frame
  double wanted = 0;
  for (size_t c = 0; c < examples.size(); ++c) {
    const double rate = lessons[c].features.rate_hz;
    for (const LabelledFrame& labelled : examples[c].labels) wanted += labelled.doubtful ? 0 : 1;
    for (const Candidate& candidate : Candidates(lessons[c].features, static_cast<int>(c))) {
      bool right = false, doubtful = false;
      for (const LabelledFrame& labelled : examples[c].labels) {
        if (labelled.label != kinds_[candidate.kind].label) continue;
        if (std::abs(labelled.frame - candidate.frame) > options_.tolerance_s * rate) continue;
        (labelled.doubtful ? doubtful : right) = true;
      }
      if (right || (!doubtful && TeachesThreshold(candidate, examples[c]))) judged.push_back({candidate.depth, right});
    }
  }
  std::stable_sort(judged.begin(), judged.end());
  double right = 0, best_score = -1;
  for (size_t i = 0; i < judged.size(); ++i) {
    if (!judged[i].second) continue;
    const double f1 = 2 * ++right / (static_cast<double>(i + 1) + wanted);
    if (f1 < best_score) continue;
    best_score = f1;
    const auto wrong = std::find_if(judged.begin() + static_cast<std::ptrdiff_t>(i), judged.end(),
                                    [](const std::pair<double, bool>& entry) { return !entry.second; });
    // Half-way to the next wrong one, on the scale of ratios.
    const double here = judged[i].first;
    threshold_ = std::sqrt(here * std::max(here, wrong == judged.end() ? kShallow : std::min(kShallow, wrong->first)));
  }
}

std::vector<LearnedKeyframe> LearnedKeyframeDetector::Detect(const MotionClip& clip) const {
  std::vector<LearnedKeyframe> found;
  for (const Candidate& candidate : Candidates(Measure(ScaledPoses(clip), clip.frame_rate_hz()), -1)) {
    if (candidate.depth <= threshold_) found.push_back({candidate.frame, kinds_[candidate.kind].label, candidate.depth});
  }
  return found;
}

std::vector<Keyframe> WalkingKeyframes(const std::vector<LearnedKeyframe>& found) {
  std::vector<Keyframe> keyframes;
  for (const LearnedKeyframe& keyframe : found) {
    if (const std::optional<KeyframeLabel> label = WalkingLabel(keyframe.label)) {
      keyframes.push_back({keyframe.frame, *label});
    }
  }
  return keyframes;
}

}  // namespace morphograph
