#include "datasets/bend.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/forward_kinematics.h"
#include "datasets/internal/cubic_spline.h"
#include "datasets/internal/smooth_envelope.h"
#include "datasets/leg_ik.h"

namespace morphograph {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMaxTurnRad = 0.6;
constexpr double kSpeedSmoothing_s = 0.12;  // the turn rate follows the walking speed, but not its ripple
constexpr double kWalking_m_s = 0.25;       // slower is standing
constexpr double kStraightest = 0.995;            // of the straight leg, unless the capture itself stretches it further
constexpr double kRelief_s = 0.15;          // how early the pelvis yields to a leg that runs out of reach
constexpr double kHipShare = 0.6;           // of a foot's turn against the body that the hip takes, the ankle the rest

Quaterniond Yaw(double angle_rad) { return Quaterniond(AngleAxisd(angle_rad, Vector3d::UnitY())); }

// A turn about the vertical and a shift: where the bent walk has what the captured one has elsewhere.
struct Placement {
  double yaw_rad = 0;
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  Vector3d operator*(const Vector3d& point) const { return to + Yaw(yaw_rad) * (point - from); }
};

// Planted time of one foot and where the bend puts it.
struct MovedStance {
  int first, last;
  Placement placement;
};

std::vector<double> WalkingSpeed(const MotionClip& clip) {
  const int frames = clip.frame_count();
  std::vector<double> speed(frames, 0.0);
  for (int f = 0; f < frames; ++f) {
    const int a = std::max(0, f - 1), b = std::min(frames - 1, f + 1);
    if (a == b) continue;
    Vector3d move = clip.root_positions().col(b) - clip.root_positions().col(a);
    move.y() = 0;
    speed[f] = move.norm() * clip.frame_rate_hz() / (b - a);
  }
  return GaussianSmoothed(speed, kSpeedSmoothing_s * clip.frame_rate_hz());
}

// Distance walked from one strike to the next foot's, mean of the clip; 0 without two strikes.
double MeanStepLength(const MotionClip& clip, const ContactTrack& contacts, const std::vector<double>& speed) {
  std::vector<int> strikes;
  for (const ContactInterval& interval : contacts.intervals) {
    if (interval.first > 0) strikes.push_back(interval.first);
  }
  std::sort(strikes.begin(), strikes.end());
  double length = 0;
  int steps = 0;
  for (size_t i = 0; i + 1 < strikes.size(); ++i) {
    double step = 0;
    for (int f = strikes[i]; f < strikes[i + 1]; ++f) step += speed[f] / clip.frame_rate_hz();
    if (step < 0.2) continue;  // standing, or two parts of one contact
    length += step;
    ++steps;
  }
  return steps > 0 ? length / steps : 0;
}

// Yaw added to each frame.
std::vector<double> TurnProfile(const MotionClip& clip, const ContactTrack& contacts, const BendOptions& options) {
  const int frames = clip.frame_count();
  const std::vector<double> speed = WalkingSpeed(clip);
  const double step_m = MeanStepLength(clip, contacts, speed);
  std::vector<double> yaw(frames, 0.0);
  if (step_m <= 0) return yaw;
  int first = frames, last = -1;
  for (int f = 0; f < frames; ++f) {
    if (speed[f] < kWalking_m_s) continue;
    first = std::min(first, f);
    last = f;
  }
  const double ease_frames = std::max(1.0, options.ease_s * clip.frame_rate_hz());
  for (int f = 1; f < frames; ++f) {
    const double middle = f - 0.5;
    const double ease = Smootherstep((middle - first) / ease_frames) * Smootherstep((last - middle) / ease_frames);
    yaw[f] = yaw[f - 1] + ease * options.turn_per_step_rad / step_m * 0.5 * (speed[f - 1] + speed[f]) / clip.frame_rate_hz();
  }
  return yaw;
}

std::vector<Placement> PlaceRoot(const MotionClip& clip, const std::vector<double>& yaw) {
  std::vector<Placement> placements(clip.frame_count());
  const Eigen::Matrix3Xd& root = clip.root_positions();
  for (int f = 0; f < clip.frame_count(); ++f) {
    placements[f].yaw_rad = yaw[f];
    placements[f].from = Vector3d(root(0, f), 0, root(2, f));
    if (f == 0) {
      placements[f].to = placements[f].from;
    } else {
      const Vector3d move = placements[f].from - placements[f - 1].from;
      placements[f].to = placements[f - 1].to + Yaw(0.5 * (yaw[f] + yaw[f - 1])) * move;
    }
  }
  return placements;
}

// Stances of one foot, one before and one after all frames included, which carry the ends of the clip.
std::vector<MovedStance> StancesOf(Foot foot, const ContactTrack& contacts, const std::vector<Placement>& placements) {
  const int frames = static_cast<int>(placements.size());
  std::vector<MovedStance> stances;
  for (const ContactInterval& interval : contacts.intervals) {
    if (interval.foot != foot) continue;
    stances.push_back({interval.first, interval.last, placements[(interval.first + interval.last) / 2]});
  }
  if (stances.empty() || stances.front().first > 0) stances.insert(stances.begin(), {-1, -1, placements.front()});
  if (stances.back().last < frames - 1) stances.push_back({frames, frames, placements.back()});
  return stances;
}

struct FootTarget {
  Vector3d ankle_m;
  double yaw_rad;
};

FootTarget TargetAt(const std::vector<MovedStance>& stances, int frame, const Vector3d& ankle) {
  size_t i = 0;
  while (stances[i].last < frame && i + 1 < stances.size()) ++i;
  if (frame >= stances[i].first || i == 0) return {stances[i].placement * ankle, stances[i].placement.yaw_rad};
  const MovedStance& from = stances[i - 1];
  const MovedStance& to = stances[i];
  const double share = Smootherstep(static_cast<double>(frame - from.last) / (to.first - from.last));
  return {(1 - share) * (from.placement * ankle) + share * (to.placement * ankle),
          (1 - share) * from.placement.yaw_rad + share * to.placement.yaw_rad};
}

}  // namespace

MotionClip Bent(const MotionClip& clip, const ContactTrack& contacts, const BendOptions& options) {
  if (!(std::abs(options.turn_per_step_rad) <= kMaxTurnRad)) {
    throw std::invalid_argument("Bent: turn_per_step_rad is " + std::to_string(options.turn_per_step_rad) + "; must be -0.6 to 0.6");
  }
  const int frames = clip.frame_count();
  if (contacts.planted.cols() != frames) {
    throw std::invalid_argument("Bent: contacts of " + std::to_string(contacts.planted.cols()) + " frames, clip of " +
                                std::to_string(frames));
  }
  MotionClip bent = clip;
  bent.name = clip.name + (options.turn_per_step_rad < 0 ? "_bent_right" : "_bent_left");
  if (frames == 0) return bent;

  const Skeleton& skeleton = clip.skeleton();
  const LegIk legs[] = {LegIk(skeleton, Foot::kLeft), LegIk(skeleton, Foot::kRight)};
  const std::vector<Placement> placements = PlaceRoot(clip, TurnProfile(clip, contacts, options));
  const int root = skeleton.moving_root();
  for (int f = 0; f < frames; ++f) {
    bent.rotation(f, root) = (Yaw(placements[f].yaw_rad) * clip.rotation(f, root)).normalized();
    const Vector3d at = placements[f] * clip.root_positions().col(f);
    bent.root_positions().col(f) = Vector3d(at.x(), clip.root_positions()(1, f), at.z());
  }

  // How far the pelvis must come down so that no leg is stretched further than in the capture or `kStraightest`.
  const std::vector<MovedStance> stances[] = {StancesOf(Foot::kLeft, contacts, placements), StancesOf(Foot::kRight, contacts, placements)};
  std::vector<FootTarget> targets[2];
  std::vector<double> excess(frames, 0.0);
  for (int side = 0; side < 2; ++side) {
    for (int f = 0; f < frames; ++f) {
      const LegMeasure own = legs[side].Measure(clip.root_positions().col(f), clip.rotations(f));
      targets[side].push_back(TargetAt(stances[side], f, own.ankle_m));
      const double reach = std::max(kStraightest * legs[side].length_m(), (own.ankle_m - own.hip_m).norm());
      const Vector3d hip = legs[side].Measure(bent.root_positions().col(f), bent.rotations(f)).hip_m;
      const Vector3d leg = targets[side][f].ankle_m - hip;
      const double across = std::hypot(leg.x(), leg.z());
      const double highest = across < reach ? std::sqrt(reach * reach - across * across) : 0;
      excess[f] = std::max(excess[f], -leg.y() - highest);
    }
  }
  const std::vector<double> relief = SmoothEnvelope(excess, static_cast<int>(std::ceil(kRelief_s * clip.frame_rate_hz())));

  for (int f = 0; f < frames; ++f) {
    bent.root_positions()(1, f) -= relief[f];
    for (int side = 0; side < 2; ++side) {
      const FootTarget& target = targets[side][f];
      const WorldPose own = ForwardKinematics(clip, f);
      const Quaterniond foot = Yaw(target.yaw_rad) * own.rotations[legs[side].ankle()];
      // Hip and ankle share the turn of the foot against the body.
      const int hip = legs[side].hip();
      const Quaterniond world_from_parent = Yaw(placements[f].yaw_rad) * own.rotations[skeleton.parent(hip)];
      const Quaterniond share = Yaw(kHipShare * (target.yaw_rad - placements[f].yaw_rad));
      bent.rotation(f, hip) = (world_from_parent.conjugate() * share * world_from_parent * clip.rotation(f, hip)).normalized();
      legs[side].Solve(target.ankle_m, foot, bent.root_positions().col(f), &bent.rotation(f, 0));
    }
  }
  return bent;
}

}  // namespace morphograph
