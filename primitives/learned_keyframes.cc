#include "primitives/learned_keyframes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "datasets/forward_kinematics.h"
#include "primitives/frame_distance.h"

namespace morphograph {
namespace {

constexpr int kWindow = 3;  // poses compared at once

// The compared joints of every frame, in leg lengths.
std::vector<Eigen::Matrix3Xd> Poses(const MotionClip& clip) {
  const std::vector<JointRole>& roles = EvaluationRoles();
  const std::vector<std::string> missing = clip.skeleton().roles().Missing(roles);
  const double leg = clip.skeleton().leg_length_m();
  if (!missing.empty() || !(leg > 0)) {
    throw std::invalid_argument("LearnedKeyframeDetector: the skeleton of '" + clip.name + "' has no " +
                                (missing.empty() ? std::string("leg bones") : "joint for " + missing.front()));
  }
  std::vector<Eigen::Matrix3Xd> poses;
  poses.reserve(clip.frame_count());
  for (const Eigen::Matrix3Xd& all : JointPositions(clip)) {
    Eigen::Matrix3Xd pose(3, static_cast<Eigen::Index>(roles.size()));
    for (size_t i = 0; i < roles.size(); ++i) {
      pose.col(static_cast<Eigen::Index>(i)) = all.col(clip.skeleton().roles()[roles[i]]) / leg;
    }
    poses.push_back(std::move(pose));
  }
  return poses;
}

// Pose between frames; beyond the ends the last change goes on.
Eigen::Matrix3Xd PoseAt(const std::vector<Eigen::Matrix3Xd>& poses, double frame) {
  const int last = static_cast<int>(poses.size()) - 1;
  if (last == 0) return poses[0];
  const int a = std::clamp(static_cast<int>(std::floor(frame)), 0, last - 1);
  return poses[a] + (frame - a) * (poses[a + 1] - poses[a]);
}

Eigen::Matrix3Xd Window(const std::vector<Eigen::Matrix3Xd>& poses, double frame, double reach_frames) {
  const Eigen::Index joints = poses[0].cols();
  Eigen::Matrix3Xd window(3, kWindow * joints);
  for (int i = 0; i < kWindow; ++i) window.middleCols(i * joints, joints) = PoseAt(poses, frame + (i - 1) * reach_frames);
  window.row(1).array() -= window.row(1).minCoeff();
  return window;
}

Eigen::VectorXd EqualWeights(Eigen::Index points) {
  return Eigen::VectorXd::Constant(points, 1.0 / static_cast<double>(points));
}

}  // namespace

LearnedKeyframeDetector::LearnedKeyframeDetector(const std::vector<KeyframeExamples>& examples,
                                                 const LearnedKeyframeOptions& options)
    : options_(options) {
  std::map<std::string, Kind> kinds;
  std::vector<std::vector<Eigen::Matrix3Xd>> poses;
  for (size_t c = 0; c < examples.size(); ++c) {
    poses.push_back(Poses(*examples[c].clip));
    const double rate = examples[c].clip->frame_rate_hz();
    std::map<std::string, int> previous;
    for (const LabelledFrame& labelled : examples[c].labels) {
      if (labelled.frame < 0 || labelled.frame >= examples[c].clip->frame_count() || labelled.doubtful) continue;
      Kind& kind = kinds[labelled.label];
      if (kind.label.empty()) kind.spacing_s = std::numeric_limits<double>::infinity();
      kind.label = labelled.label;
      kind.examples.push_back({Window(poses[c], labelled.frame, options_.window_s * rate), static_cast<int>(c)});
      const auto before = previous.find(labelled.label);
      if (before != previous.end()) {
        kind.spacing_s = std::min(kind.spacing_s, options_.spacing * (labelled.frame - before->second) / rate);
      }
      previous[labelled.label] = labelled.frame;
    }
  }
  if (kinds.empty()) throw std::invalid_argument("LearnedKeyframeDetector: no labelled frame in any example clip");
  for (auto& [label, kind] : kinds) {
    if (!std::isfinite(kind.spacing_s)) kind.spacing_s = 0;
    kind.threshold = std::numeric_limits<double>::infinity();
    kinds_.push_back(std::move(kind));
  }
  SetThresholds(examples, poses);
}

std::vector<LearnedKeyframeDetector::Candidate> LearnedKeyframeDetector::Candidates(
    const std::vector<Eigen::Matrix3Xd>& poses, double rate_hz, int without_clip) const {
  if (poses.empty()) return {};
  const double reach = options_.window_s * rate_hz;
  const double last = static_cast<double>(poses.size()) - 1;
  const double stride = std::max(1.0, rate_hz / options_.search_rate_hz);
  std::vector<Eigen::Matrix3Xd> windows;
  // Only where the whole window lies in the clip: at the ends a minimum cannot be told from a slope.
  const double first = reach, end = last - reach;
  for (double frame = first; frame <= end; frame += stride) windows.push_back(Window(poses, frame, reach));
  if (windows.empty()) return {};
  const int count = static_cast<int>(windows.size());
  const int kinds = static_cast<int>(kinds_.size());
  const Eigen::VectorXd weights = EqualWeights(windows[0].cols());

  Eigen::MatrixXd nearest = Eigen::MatrixXd::Constant(kinds, count, std::numeric_limits<double>::infinity());
  std::vector<std::vector<Eigen::Matrix3Xd>> used(kinds);
  for (int k = 0; k < kinds; ++k) {
    for (const Example& example : kinds_[k].examples) {
      if (example.clip != without_clip) used[k].push_back(example.points);
    }
    if (!used[k].empty()) nearest.row(k) = FrameDistanceMatrix(used[k], windows, weights).colwise().minCoeff();
  }
  const auto distance = [&](int kind, double frame) {
    const std::vector<Eigen::Matrix3Xd> window = {Window(poses, frame, reach)};
    return FrameDistanceMatrix(used[kind], window, weights).minCoeff();
  };

  std::vector<Candidate> candidates;
  for (int k = 0; k < kinds; ++k) {
    const auto row = nearest.row(k);
    for (int i = 0; i < count; ++i) {
      if (i == 0 || i + 1 == count || !(row[i] < row[i - 1]) || !(row[i] <= row[i + 1])) continue;
      if (!std::isfinite(row[i]) || nearest.col(i).minCoeff() < row[i]) continue;
      // Refined in halves around the coarse minimum, then by a parabola.
      double frame = first + i * stride, best = row[i];
      for (double step = stride / 2; step >= 0.5; step /= 2) {
        for (const double at : {frame - step, frame + step}) {
          if (at < first || at > end) continue;
          const double d = distance(k, at);
          if (d < best) {
            best = d;
            frame = at;
          }
        }
      }
      const double step = std::max(0.5, stride / 4);
      if (frame - step >= first && frame + step <= end) {
        const double before = distance(k, frame - step), after = distance(k, frame + step);
        const double curvature = before - 2 * best + after;
        if (curvature > 0) frame += std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0) * step;
      }
      candidates.push_back({frame, k, best});
    }
  }
  // Of two of a kind that are too close the nearer to the examples stays.
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const double spacing = kinds_[candidate.kind].spacing_s * rate_hz;
    const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return other.kind == candidate.kind && std::abs(other.frame - candidate.frame) < spacing;
    });
    if (!crowded) kept.push_back(candidate);
  }
  std::stable_sort(kept.begin(), kept.end(), [](const Candidate& a, const Candidate& b) { return a.frame < b.frame; });
  return kept;
}

void LearnedKeyframeDetector::SetThresholds(const std::vector<KeyframeExamples>& examples,
                                            const std::vector<std::vector<Eigen::Matrix3Xd>>& poses) {
  const bool several = std::any_of(examples.begin() + 1, examples.end(),
                                   [](const KeyframeExamples& clip) { return !clip.labels.empty(); });
  std::vector<std::vector<std::pair<double, bool>>> judged(kinds_.size());  // distance, is a key frame
  for (size_t c = 0; c < examples.size(); ++c) {
    const double rate = examples[c].clip->frame_rate_hz();
    for (const Candidate& candidate : Candidates(poses[c], rate, several ? static_cast<int>(c) : -1)) {
      bool right = false, doubtful = false;
      for (const LabelledFrame& labelled : examples[c].labels) {
        if (labelled.label != kinds_[candidate.kind].label) continue;
        if (std::abs(labelled.frame - candidate.frame) > options_.tolerance_s * rate) continue;
        (labelled.doubtful ? doubtful : right) = true;
      }
      if (right || !doubtful) judged[candidate.kind].push_back({candidate.distance, right});
    }
  }
  for (size_t k = 0; k < kinds_.size(); ++k) {
    std::stable_sort(judged[k].begin(), judged[k].end());
    const double wanted = static_cast<double>(kinds_[k].examples.size());
    double right = 0, best_score = -1, best = 0;
    for (size_t i = 0; i < judged[k].size(); ++i) {
      right += judged[k][i].second ? 1 : 0;
      const double f1 = 2 * right / (static_cast<double>(i + 1) + wanted);
      if (f1 < best_score || !judged[k][i].second) continue;
      best_score = f1;
      // Half-way to the next wrong one, or twice as far where there is none.
      const auto wrong = std::find_if(judged[k].begin() + static_cast<std::ptrdiff_t>(i), judged[k].end(),
                                      [](const std::pair<double, bool>& entry) { return !entry.second; });
      const double here = judged[k][i].first;
      best = wrong == judged[k].end() ? 2 * here : 0.5 * (here + std::min(wrong->first, 3 * here));
    }
    kinds_[k].threshold = best;
  }
}

std::vector<LearnedKeyframe> LearnedKeyframeDetector::Detect(const MotionClip& clip) const {
  std::vector<LearnedKeyframe> found;
  for (const Candidate& candidate : Candidates(Poses(clip), clip.frame_rate_hz(), -1)) {
    const Kind& kind = kinds_[candidate.kind];
    if (candidate.distance <= kind.threshold) found.push_back({candidate.frame, kind.label, candidate.distance});
  }
  return found;
}

std::map<std::string, double> LearnedKeyframeDetector::thresholds() const {
  std::map<std::string, double> thresholds;
  for (const Kind& kind : kinds_) thresholds[kind.label] = kind.threshold;
  return thresholds;
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
