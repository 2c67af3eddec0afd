#include "primitives/decomposition.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "datasets/contact_detector.h"

namespace morphograph {
namespace {

constexpr double kSwing = 0.12;  // m; a foot that travels less has not stepped
// A walking step stands on one foot and swings the other: measured shares of stance are 0.92 and more for walks of all
// styles, 0.75 and less for runs and hops; shares of swing 0.35 and more.
constexpr double kLeastStance = 0.85;
constexpr double kLeastSwing = 0.2;
constexpr double kMostLift = 0.25;  // m; walks lift the ball of the foot by 0.18 m at most, kicks and climbing more
constexpr int kFewestOfClip = 4;    // segments, to tell a slow first or last step by
constexpr int kFrozenFrames = 3;
constexpr double kFrozenSpeed = 0.3;  // m/s; of the pelvis, at the edge of frames that do not change at all
constexpr double kUnchanged = 1e-6;   // m/s; held frames that were resampled differ by rounding, living ones by mm/s
constexpr double kFrozenEdge_s = 0.06;  // resampling spreads the edge over a few frames; nobody stops within so short a time

bool IsStance(KeyframeLabel label) {
  return label == KeyframeLabel::kLeftStance || label == KeyframeLabel::kRightStance;
}
int Side(KeyframeLabel label) { return label == KeyframeLabel::kLeftStance ? 0 : 1; }
const char* SideName(int side) { return side == 0 ? "left" : "right"; }

void CheckKeyframes(const MotionClip& clip, const std::vector<Keyframe>& keyframes) {
  double before = 0;
  for (const Keyframe& keyframe : keyframes) {
    if (!(keyframe.frame >= before) || keyframe.frame > clip.frame_count() - 1) {
      throw std::invalid_argument("Decompose: key frame " + std::to_string(keyframe.frame) + " of '" + clip.name +
                                  "' is out of order or outside the clip of " + std::to_string(clip.frame_count()) +
                                  " frames");
    }
    before = keyframe.frame;
  }
}

Eigen::Vector2d OnFloor(const Eigen::Matrix3Xd& path, double frame) {
  const int a = std::clamp(static_cast<int>(std::floor(frame)), 0, static_cast<int>(path.cols()) - 1);
  const int b = std::min<int>(a + 1, static_cast<int>(path.cols()) - 1);
  const Eigen::Vector3d point = path.col(a) + (frame - a) * (path.col(b) - path.col(a));
  return {point.x(), point.z()};
}

// What is measured of a clip once, for all of its segments.
struct Measures {
  const MotionClip& clip;
  ContactTrack contacts;
  double rate;

  double Way(int foot, double from, double to) const {
    return (OnFloor(contacts.balls[foot], to) - OnFloor(contacts.balls[foot], from)).norm();
  }
  // Metres a second of the pelvis along its way.
  double Speed(const Segment& segment) const {
    const Eigen::Matrix3Xd& root = clip.root_positions();
    double way = 0;
    Eigen::Vector2d at = OnFloor(root, segment.start_frame);
    for (int f = static_cast<int>(std::floor(segment.start_frame)) + 1; f <= segment.end_frame; ++f) {
      way += (OnFloor(root, f) - at).norm();
      at = OnFloor(root, f);
    }
    way += (OnFloor(root, segment.end_frame) - at).norm();
    return way * rate / (segment.end_frame - segment.start_frame);
  }
  // Angle between the course of the pelvis and where it faces half-way.
  double Drift(const Segment& segment) const {
    const Eigen::Vector2d course =
        OnFloor(clip.root_positions(), segment.end_frame) - OnFloor(clip.root_positions(), segment.start_frame);
    if (course.norm() < 0.05) return 0;
    const double heading = HeadingRad(clip, static_cast<int>(std::lround(0.5 * (segment.start_frame + segment.end_frame))));
    const Eigen::Vector2d facing(std::sin(heading), std::cos(heading));
    return std::acos(std::clamp(facing.dot(course.normalized()), -1.0, 1.0));
  }
  // Share of the segment in which a foot stands.
  double Planted(int foot, const Segment& segment) const {
    int planted = 0, frames = 0;
    for (int f = static_cast<int>(std::ceil(segment.start_frame)); f <= segment.end_frame; ++f, ++frames) {
      planted += contacts.planted.col(f).segment<2>(2 * foot).any() ? 1 : 0;
    }
    return frames > 0 ? static_cast<double>(planted) / frames : 1;
  }
  // How high a ball of the foot is lifted above where it stands, metres.
  double Lift(const Segment& segment) const {
    double lift = 0;
    for (int f = static_cast<int>(std::ceil(segment.start_frame)); f <= segment.end_frame; ++f) {
      for (const Eigen::Matrix3Xd& ball : contacts.balls) lift = std::max(lift, ball(1, f) - contacts.ground_m[f]);
    }
    return lift;
  }
  // Share of the segment in which no foot stands.
  double Airborne(const Segment& segment) const {
    int airborne = 0, frames = 0;
    for (int f = static_cast<int>(std::ceil(segment.start_frame)); f <= segment.end_frame; ++f, ++frames) {
      airborne += contacts.planted.col(f).any() ? 0 : 1;
    }
    return frames > 0 ? static_cast<double>(airborne) / frames : 0;
  }
  // Whether the recording freezes while the body moves: some captures hold their first or last pose.
  bool Frozen(double from, double to) const {
    const Eigen::Matrix3Xd& root = clip.root_positions();
    const int last = std::min(clip.frame_count() - 2, static_cast<int>(std::floor(to)));
    const auto speed = [&](int f) { return (root.col(f + 1) - root.col(f)).norm() * rate; };
    for (int f = std::max(0, static_cast<int>(std::ceil(from))); f <= last; ++f) {
      if (speed(f) > kUnchanged) continue;
      int end = f, begin = f;
      while (end + 1 < clip.frame_count() - 1 && speed(end + 1) <= kUnchanged) ++end;
      while (begin > 0 && speed(begin - 1) <= kUnchanged) --begin;
      const int edge = std::max(1, static_cast<int>(std::lround(kFrozenEdge_s * rate)));
      double beside = 0;
      for (int i = 1; i <= edge; ++i) {
        if (begin - i >= 0) beside = std::max(beside, speed(begin - i));
        if (end + i < clip.frame_count() - 1) beside = std::max(beside, speed(end + i));
      }
      if (end - begin + 1 >= kFrozenFrames && beside > kFrozenSpeed) return true;
      f = end;
    }
    return false;
  }
};

// The piece from key frame `i` to the next, or nothing where that is no segment. `skipped` is set when the next key
// frame is passed over because its step ends in the stand that follows it.
std::optional<Segment> Piece(const std::vector<Keyframe>& keyframes, size_t i, const Measures& measures,
                             const std::string& action, bool* skipped) {
  *skipped = false;
  const Keyframe& from = keyframes[i];
  const Keyframe* to = &keyframes[i + 1];
  Segment segment;
  segment.start_frame = from.frame;
  segment.start = from.label;
  if (!IsStance(from.label)) {
    if (!IsStance(to->label)) return std::nullopt;
    segment.primitive = std::string(SideName(Side(to->label))) + "_first_start";
  } else if (!IsStance(to->label)) {
    const int other = 1 - Side(from.label);
    if (measures.Way(other, from.frame, to->frame) < kSwing) return std::nullopt;  // `from` was itself the last step
    segment.primitive = std::string(SideName(other)) + "_end";
  } else if (to->label == from.label) {
    return std::nullopt;
  } else {
    const int side = Side(to->label);
    const bool stand_follows = i + 2 < keyframes.size() && !IsStance(keyframes[i + 2].label);
    if (stand_follows && measures.Way(1 - side, to->frame, keyframes[i + 2].frame) < kSwing) {
      to = &keyframes[i + 2];
      *skipped = true;
      segment.primitive = std::string(SideName(side)) + "_end";
    } else {
      segment.primitive = std::string(SideName(side)) + "_" + action;
    }
  }
  segment.end_frame = to->frame;
  segment.end = to->label;
  return segment;
}

bool IsStep(const Segment& segment) { return IsStance(segment.start) && IsStance(segment.end); }

// Steps in a row from `first` in direction `step` that are slower than `limit` are not steady.
void MarkSlowRun(std::vector<Segment>* segments, const std::vector<double>& speeds, int first, int step, double limit) {
  for (int i = first;; i += step) {
    Segment& segment = (*segments)[i];
    if (!IsStep(segment) || speeds[i] >= limit) return;
    segment.steady = false;
    const int next = i + step;
    if (next < 0 || next >= static_cast<int>(segments->size())) return;
    if ((*segments)[std::max(i, next)].previous != std::min(i, next)) return;  // not one motion
  }
}

void MarkUnsteady(std::vector<Segment>* segments, const Measures& measures, const DecompositionOptions& options) {
  std::vector<double> speeds, step_speeds, step_lengths;
  for (const Segment& segment : *segments) {
    speeds.push_back(measures.Speed(segment));
    if (!IsStep(segment)) continue;
    step_speeds.push_back(speeds.back());
    step_lengths.push_back(segment.end_frame - segment.start_frame);
  }
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  };
  const bool flies = options.action != "walk";
  const int count = static_cast<int>(segments->size());
  for (int i = 0; i < count; ++i) {
    Segment& segment = (*segments)[i];
    if (measures.Drift(segment) > options.max_drift_rad) segment.steady = false;
    const double margin = options.margin * (segment.end_frame - segment.start_frame);
    if (measures.Frozen(segment.start_frame - margin, segment.end_frame + margin)) segment.steady = false;
    if (!flies && (measures.Airborne(segment) > 1 - kLeastStance || measures.Lift(segment) > kMostLift)) {
      segment.steady = false;
    }
    if (!IsStep(segment)) continue;
    const int swing = Side(segment.end);
    if (!flies && (measures.Planted(1 - swing, segment) < kLeastStance ||
                   measures.Planted(swing, segment) > 1 - kLeastSwing)) {
      segment.steady = false;
    }
    // Next to a start or a stop speed still changes, whatever it is.
    const bool after_start = segment.previous >= 0 && !IsStep((*segments)[segment.previous]);
    const bool before_stop = i + 1 < count && (*segments)[i + 1].previous == i && !IsStep((*segments)[i + 1]);
    if (after_start || before_stop) segment.steady = false;
    const double length = segment.end_frame - segment.start_frame;
    const double usual = median(step_lengths);
    if (length > options.duration_ratio * usual || length * options.duration_ratio < usual) segment.steady = false;
  }
  if (step_speeds.empty()) return;
  const double slow = options.slow_ratio * median(step_speeds);
  const bool sound[2] = {segments->front().steady, segments->back().steady};
  for (int i = 0; i < count; ++i) {
    if (!IsStep((*segments)[i])) continue;
    const int previous = (*segments)[i].previous;
    const bool begins = previous < 0 || !IsStep((*segments)[previous]);
    const bool ends = i + 1 == count || (*segments)[i + 1].previous != i || !IsStep((*segments)[i + 1]);
    if (begins) MarkSlowRun(segments, speeds, i, 1, slow);
    if (ends) MarkSlowRun(segments, speeds, i, -1, slow);
  }
  // A clip of a few steps says little of what is usual, and a step that nothing follows starts nothing.
  if (count < kFewestOfClip) return;
  const auto slow_and_slower_than = [&](int i, int neighbour) {
    return IsStep((*segments)[i]) && IsStep((*segments)[neighbour]) && speeds[i] < slow && speeds[i] < speeds[neighbour];
  };
  if (sound[0] && slow_and_slower_than(0, 1) && (*segments)[1].previous == 0) {
    Segment& first = segments->front();
    first.start = KeyframeLabel::kDoubleStance;
    first.primitive = std::string(SideName(Side(first.end))) + "_first_start";
    first.steady = first.slow_step = true;
  }
  if (sound[1] && slow_and_slower_than(count - 1, count - 2) && segments->back().previous == count - 2) {
    Segment& last = segments->back();
    last.primitive = std::string(SideName(Side(last.end))) + "_end";
    last.end = KeyframeLabel::kDoubleStance;
    last.steady = last.slow_step = true;
  }
}

}  // namespace

std::vector<Segment> Decompose(const MotionClip& clip, int clip_index, const std::vector<Keyframe>& keyframes,
                               const DecompositionOptions& options) {
  CheckKeyframes(clip, keyframes);
  const Measures measures{clip, DetectContacts(clip), clip.frame_rate_hz()};
  std::vector<Segment> segments;
  for (size_t i = 0; i + 1 < keyframes.size(); ++i) {
    bool skipped = false;
    std::optional<Segment> segment = Piece(keyframes, i, measures, options.action, &skipped);
    if (skipped) ++i;
    if (!segment) continue;
    const double length = segment->end_frame - segment->start_frame;
    if (length < options.min_step_s * measures.rate || length > options.max_step_s * measures.rate) continue;
    const double margin = options.margin * length;
    if (segment->start_frame < margin || segment->end_frame + margin > clip.frame_count() - 1) continue;
    segment->clip = clip_index;
    if (!segments.empty() && segments.back().end_frame == segment->start_frame) {
      segment->previous = static_cast<int>(segments.size()) - 1;
    }
    segments.push_back(*std::move(segment));
  }
  MarkUnsteady(&segments, measures, options);
  return segments;
}

}  // namespace morphograph
