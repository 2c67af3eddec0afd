#include "primitives/keyframe_detector.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"
#include "datasets/low_pass.h"

namespace morphograph {
namespace {

// Low-passed paths over which features are taken.
struct Paths {
  Eigen::Matrix3Xd ankles[2];  // left, right
  Eigen::Matrix3Xd balls[2];
  Eigen::Matrix3Xd pelvis;
  Eigen::VectorXd distance;  // between the ankles, over the floor
  double rate = 0;
  int frames = 0;
};

struct Landing {
  int side = 0;
  double frame = 0;
  double strength = 0;  // of two that are too close the stronger stays
};

struct Phase {
  int first, last;
};

Eigen::Vector2d OnFloor(const Eigen::Vector3d& point) { return {point.x(), point.z()}; }

Paths MakePaths(const MotionClip& clip, const ContactTrack& contacts, double low_pass_hz) {
  Paths paths;
  paths.frames = clip.frame_count();
  paths.rate = clip.frame_rate_hz();
  const RoleMap& roles = clip.skeleton().roles();
  Eigen::MatrixXd ankles(6, paths.frames);
  WorldPose pose;
  for (int f = 0; f < paths.frames; ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    ankles.col(f) << pose.positions.col(roles[JointRole::kLeftAnkle]), pose.positions.col(roles[JointRole::kRightAnkle]);
  }
  const auto filtered = [&](const Eigen::MatrixXd& path) { return LowPass(path, paths.rate, low_pass_hz); };
  ankles = filtered(ankles);
  for (int side = 0; side < 2; ++side) {
    paths.ankles[side] = ankles.middleRows(3 * side, 3);
    paths.balls[side] = filtered(contacts.balls[side]);
  }
  paths.pelvis = filtered(clip.root_positions());
  const Eigen::Matrix3Xd between = paths.ankles[0] - paths.ankles[1];
  paths.distance = (between.row(0).cwiseAbs2() + between.row(2).cwiseAbs2()).cwiseSqrt().transpose();
  return paths;
}

// Place of the extremum of the parabola through three neighbouring samples.
double ParabolaPeak(const Eigen::VectorXd& values, int at) {
  const double before = values[at - 1], here = values[at], after = values[at + 1];
  const double curvature = before - 2 * here + after;
  return curvature < 0 ? at + 0.5 * (before - after) / curvature : at;
}

double PathLength(const Eigen::Matrix3Xd& path, int first, int last) {
  double length = 0;
  for (int f = first; f < last; ++f) length += OnFloor(path.col(f + 1) - path.col(f)).norm();
  return length;
}

// Where the feet passed before (step -1) or after (step 1) a peak: the lowest sample on that side, up to where the
// distance has risen by `needed` again, is higher than the peak, or the clip ends.
int PassBeside(const Eigen::VectorXd& distance, int peak, int step, double needed) {
  int lowest = peak;
  for (int f = peak + step; f >= 0 && f < distance.size(); f += step) {
    if (distance[f] > distance[peak] || distance[f] > distance[lowest] + needed) break;
    if (distance[f] < distance[lowest]) lowest = f;
  }
  return lowest;
}

// Puts the landing of a distance peak at the landing foot's greatest reach ahead of the pelvis.
std::optional<double> LandingFrame(const Paths& paths, int side, int pass, int peak, const KeyframeOptions& options) {
  const Eigen::Vector2d across = OnFloor(paths.ankles[side].col(peak) - paths.ankles[1 - side].col(peak));
  if (across.norm() < 1e-9) return std::nullopt;
  const Eigen::Vector2d ahead = across.normalized();
  const int last = std::min(paths.frames - 1, peak + static_cast<int>(std::lround(0.1 * paths.rate)));
  Eigen::VectorXd reach(last - pass + 1);
  for (int f = pass; f <= last; ++f) reach[f - pass] = ahead.dot(OnFloor(paths.ankles[side].col(f) - paths.pelvis.col(f)));
  int best = 0;
  reach.maxCoeff(&best);
  if (best == 0 || best == reach.size() - 1) return std::nullopt;
  return pass + ParabolaPeak(reach, best) + options.landing_delay_s * paths.rate;
}

// Whether the foot comes to rest after it landed, measured by its own swing: a leg that swings to and fro in the air
// makes peaks of distance too.
bool ComesToRest(const Paths& paths, int side, int pass, double landing, double rest_ratio) {
  const Eigen::Matrix3Xd& ball = paths.balls[side];
  const int last = std::min(paths.frames - 2, static_cast<int>(std::lround(landing + 0.2 * paths.rate)));
  double fastest = 0, slowest = std::numeric_limits<double>::infinity();
  for (int f = pass; f <= last; ++f) {
    const double step = (ball.col(f + 1) - ball.col(f)).norm();
    if (f < landing) fastest = std::max(fastest, step);
    if (f + 1 > landing) slowest = std::min(slowest, step);
  }
  return slowest <= rest_ratio * fastest;
}

std::vector<Landing> LandingsByDistance(const Paths& paths, const KeyframeOptions& options) {
  std::vector<Landing> landings;
  const Eigen::VectorXd& d = paths.distance;
  const double needed = options.min_prominence * (d.maxCoeff() - d.minCoeff());
  for (int f = 1; f < paths.frames; ++f) {
    const bool at_end = f + 1 == paths.frames;
    if (d[f] < d[f - 1] || (!at_end && d[f] <= d[f + 1])) continue;
    const int pass = PassBeside(d, f, -1, needed);
    const int next_pass = PassBeside(d, f, 1, needed);
    // At the ends of the clip the feet may not be seen to pass; there the swing and the reach decide alone.
    const bool cut_at_start = pass == 0;
    const bool cut_at_end = f + options.min_step_s * paths.rate >= paths.frames - 1;
    if (!cut_at_start && d[f] - d[pass] < needed) continue;
    if (!cut_at_end && d[f] - d[next_pass] < needed) continue;
    const double way[2] = {PathLength(paths.ankles[0], pass, f), PathLength(paths.ankles[1], pass, f)};
    const int side = way[0] >= way[1] ? 0 : 1;
    // The swing began before the feet passed: measured over a step's time.
    const int since = std::max(0, f - static_cast<int>(std::lround(0.6 * paths.rate)));
    if (PathLength(paths.ankles[side], std::min(since, pass), f) < options.min_swing_m) continue;
    const std::optional<double> reach = LandingFrame(paths, side, pass, f, options);
    if (!reach && at_end) continue;
    if (!ComesToRest(paths, side, pass, reach ? *reach : f, options.rest_ratio)) continue;
    landings.push_back({side, reach ? *reach : ParabolaPeak(d, f), d[f]});
  }
  return landings;
}

std::vector<Landing> LandingsByContact(const ContactTrack& contacts, const Paths& paths, const KeyframeOptions& options) {
  std::vector<Landing> landings;
  const ContactInterval* before[2] = {nullptr, nullptr};
  for (const ContactInterval& contact : contacts.intervals) {
    const int side = contact.foot == Foot::kLeft ? 0 : 1;
    const int lifted = before[side] ? before[side]->last : 0;
    before[side] = &contact;
    if (contact.first == 0) continue;
    const double way = PathLength(paths.balls[side], lifted, contact.first);
    if (way >= options.min_swing_m) landings.push_back({side, static_cast<double>(contact.first), way});
  }
  return landings;
}

// Whether both feet are on the floor in all frames of [first, last].
bool BothStand(const ContactTrack& contacts, int first, int last) {
  bool stands[2] = {false, false};
  for (const ContactInterval& contact : contacts.intervals) {
    if (contact.first <= first && last <= contact.last) stands[contact.foot == Foot::kLeft ? 0 : 1] = true;
  }
  return stands[0] && stands[1];
}

// Of landings closer than the least step time the stronger stays; the sooner where they are equal.
std::vector<Landing> Thinned(std::vector<Landing> landings, double min_frames) {
  std::stable_sort(landings.begin(), landings.end(), [](const Landing& a, const Landing& b) { return a.frame < b.frame; });
  std::vector<Landing> kept;
  for (const Landing& landing : landings) {
    if (kept.empty() || landing.frame - kept.back().frame >= min_frames) {
      kept.push_back(landing);
    } else if (landing.strength > kept.back().strength) {
      kept.back() = landing;
    }
  }
  return kept;
}

Eigen::VectorXd CentralSpeed(const Eigen::Matrix3Xd& path, double rate) {
  const Eigen::Index frames = path.cols();
  Eigen::VectorXd speed = Eigen::VectorXd::Zero(frames);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Index a = std::max<Eigen::Index>(f - 1, 0), b = std::min(f + 1, frames - 1);
    if (b > a) speed[f] = (path.col(b) - path.col(a)).norm() * rate / static_cast<double>(b - a);
  }
  return speed;
}

// Phases in which `holds` is true for at least `min_frames`, shorter breaks than `max_gap_frames` aside.
template <typename Predicate>
std::vector<Phase> PhasesWhere(int frames, double min_frames, double max_gap_frames, Predicate holds) {
  std::vector<Phase> phases;
  for (int f = 0; f < frames; ++f) {
    if (!holds(f)) continue;
    int last = f;
    while (last + 1 < frames && holds(last + 1)) ++last;
    if (!phases.empty() && f - phases.back().last - 1 <= max_gap_frames) {
      phases.back().last = last;
    } else {
      phases.push_back({f, last});
    }
    f = last;
  }
  std::erase_if(phases, [&](const Phase& phase) { return phase.last - phase.first + 1 < min_frames; });
  return phases;
}

bool Inside(const std::vector<Phase>& phases, double frame) {
  return std::any_of(phases.begin(), phases.end(),
                     [&](const Phase& phase) { return phase.first < frame && frame < phase.last; });
}

}  // namespace

bool HasKeyframeFeatures(std::string_view action) { return action == "walk" || action == "run"; }

KeyframeOptions KeyframeOptionsFor(std::string_view action) {
  KeyframeOptions options;
  if (action == "walk") return options;
  if (action == "run") {
    options.landing = LandingFeature::kContact;
    options.min_step_s = 0.15;
    return options;
  }
  throw std::invalid_argument("KeyframeOptionsFor: no feature-based key frames for action '" + std::string(action) +
                              "'; known: walk, run");
}

std::vector<Keyframe> DetectKeyframes(const MotionClip& clip, const KeyframeOptions& options) {
  const ContactTrack contacts = DetectContacts(clip);
  if (clip.frame_count() < 3) return {};
  const Paths paths = MakePaths(clip, contacts, options.low_pass_hz);
  const double rate = paths.rate;

  const Eigen::VectorXd pelvis_speed = CentralSpeed(paths.pelvis, rate);
  const Eigen::VectorXd foot_speed =
      CentralSpeed(paths.balls[0], rate).cwiseMax(CentralSpeed(paths.balls[1], rate));
  const std::vector<Phase> standing =
      PhasesWhere(paths.frames, options.min_standing_s * rate, options.max_standing_gap_s * rate, [&](int f) {
        return pelvis_speed[f] < options.standing_pelvis_m_s && foot_speed[f] < options.standing_foot_m_s;
      });

  std::vector<Landing> landings = options.landing == LandingFeature::kReach
                                      ? LandingsByDistance(paths, options)
                                      : LandingsByContact(contacts, paths, options);
  landings = Thinned(std::move(landings), options.min_step_s * rate);
  std::erase_if(landings, [&](const Landing& landing) {
    return landing.frame > paths.frames - 1 - options.min_seen_s * rate || Inside(standing, landing.frame);
  });

  // A foot that closes up before a stand never parts from the other: no peak, but a contact, after which no foot moves again.
  if (options.landing == LandingFeature::kReach && !standing.empty()) {
    const size_t by_distance = landings.size();
    for (const Landing& closing : LandingsByContact(contacts, paths, options)) {
      const bool before_stand = std::any_of(standing.begin(), standing.end(), [&](const Phase& phase) {
        return closing.frame <= phase.first && BothStand(contacts, static_cast<int>(closing.frame), phase.first);
      });
      const bool found = std::any_of(landings.begin(), landings.begin() + static_cast<std::ptrdiff_t>(by_distance),
                                     [&](const Landing& landing) {
                                       return std::abs(landing.frame - closing.frame) < options.min_step_s * rate;
                                     });
      if (before_stand && !found) landings.push_back(closing);
    }
  }

  std::vector<Keyframe> keyframes;
  for (const Landing& landing : landings) {
    keyframes.push_back({landing.frame, landing.side == 0 ? KeyframeLabel::kLeftStance : KeyframeLabel::kRightStance});
  }
  for (const Phase& phase : standing) {
    keyframes.push_back({static_cast<double>(phase.first), KeyframeLabel::kStanding});
    if (phase.last > phase.first) keyframes.push_back({static_cast<double>(phase.last), KeyframeLabel::kStanding});
  }
  const double low = 0.5 * (paths.distance.maxCoeff() + paths.distance.minCoeff());
  for (const Phase& phase : PhasesWhere(paths.frames, options.min_standing_s * rate, 0, [&](int f) {
         return paths.distance[f] < low && foot_speed[f] < options.standing_foot_m_s;
       })) {
    const bool stands = std::any_of(standing.begin(), standing.end(), [&](const Phase& stand) {
      return stand.first <= phase.last && phase.first <= stand.last;
    });
    if (stands) continue;
    int least = 0;
    paths.distance.segment(phase.first, phase.last - phase.first + 1).minCoeff(&least);
    keyframes.push_back({static_cast<double>(phase.first + least), KeyframeLabel::kDoubleStance});
  }
  std::stable_sort(keyframes.begin(), keyframes.end(),
                   [](const Keyframe& a, const Keyframe& b) { return a.frame < b.frame; });
  return keyframes;
}

}  // namespace morphograph
