#include "synthesis/foot_lock.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "datasets/leg_ik.h"
#include "synthesis/internal/pentadiagonal_system.h"

namespace morphograph {
namespace {

constexpr double kNegligible_m = 1e-6;
constexpr double kFloorGive_m = 0.005;     // that joints may sink below y = 0: floors are level to half a centimetre
constexpr double kLeastUpright = 0.5;      // of a leg: the most that a drop makes up for is twice what the leg is short of
constexpr double kLargestDrop_m = 0.05;    // a foot that is further up does not stand, whatever its chance
constexpr double kNearlyStraight = 0.985;  // of the leg's length: knees bent by less than some 20 degrees

// One foot over a clip.
struct FootPath {
  Eigen::Matrix3Xd hips, ankles;
  Eigen::Matrix3Xd parts[2];  // heel, ball
};

FootPath PathOf(const LegIk& leg, const Eigen::Vector3d& heel_offset_m, const MotionClip& clip) {
  const int frames = clip.frame_count();
  FootPath path;
  path.hips.resize(3, frames);
  path.ankles.resize(3, frames);
  for (Eigen::Matrix3Xd& part : path.parts) part.resize(3, frames);
  for (int f = 0; f < frames; ++f) {
    const LegPlace place = leg.Place(clip.root_positions().col(f), clip.rotations(f));
    path.hips.col(f) = place.hip_m;
    path.ankles.col(f) = place.ankle_m;
    path.parts[0].col(f) = place.ankle_m + place.world_from_foot * heel_offset_m;
    path.parts[1].col(f) = place.toe_m;
  }
  return path;
}

// What a part of a foot is meant to do, frame by frame.
struct PartTarget {
  Eigen::VectorXd hold;      // c, 0 to 1
  Eigen::VectorXd height_m;
  Eigen::Matrix3Xd slide_m;  // to the next frame, level
};

PartTarget TargetOf(int side, int part, const FeetGeometry& feet, const ContactProfile& contacts, const std::vector<double>& headings,
                    double rate_hz, const FootLockOptions& options) {
  const int row = 2 * side + part;
  const double standing = part == 0 ? feet.heel_height_m[side] : feet.ball_height_m[side];
  PartTarget target;
  const Eigen::Index frames = contacts.cols();
  const auto sure = (contacts.row(kPlantedChance + row).transpose().array() - options.loose_chance) / (1 - options.loose_chance);
  const Eigen::ArrayXd t = sure.max(0).min(1);
  target.hold = t.square() * (3 - 2 * t);
  target.height_m.resize(frames);
  for (Eigen::Index f = 0; f < frames; ++f) target.height_m[f] = HeldHeight_m(standing, contacts(kPlantedHeight + row, f), options);
  target.slide_m = Eigen::Matrix3Xd::Zero(3, frames);
  for (Eigen::Index f = 0; f + 1 < frames; ++f) {
    const auto between = [&](int first) { return 0.5 * (contacts(first + row, f) + contacts(first + row, f + 1)); };
    const Eigen::Vector3d velocity = Yaw(headings[static_cast<size_t>(f)]) * Eigen::Vector3d(between(kSlideLeft), 0, between(kSlideForward));
    // Only where it is sure to be planted: on the way into and out of a stance the foot moves as captured.
    const double firm = 0.5 * (target.hold[f] + target.hold[f + 1]);
    target.slide_m.col(f) = (1 - firm * (1 - options.slide)) / rate_hz * velocity;
  }
  return target;
}

// Shift of the ankle in every frame, see LockFeet.
Eigen::Matrix3Xd Shifts(const FootPath& path, const PartTarget (&targets)[2], double rate_hz, const FootLockOptions& options) {
  const int frames = static_cast<int>(path.ankles.cols());
  const double still = std::pow(options.hold_s * rate_hz, 2), smooth = std::pow(options.ease_s * rate_hz, 4);
  internal::PentadiagonalSystem planar(frames), vertical(frames);
  Eigen::VectorXd sides[3];  // right sides by axis, then solutions
  for (Eigen::VectorXd& side : sides) side = Eigen::VectorXd::Zero(frames);
  for (int f = 0; f < frames; ++f) {
    planar.Add<1>(1, f, {1});
    vertical.Add<1>(1, f, {1});
    for (int part = 0; part < 2; ++part) {
      const PartTarget& target = targets[part];
      const Eigen::Matrix3Xd& points = path.parts[part];
      const double level = options.level * target.hold[f];
      vertical.Add<1>(level, f, {1});
      sides[1][f] += level * (target.height_m[f] - points(1, f));
      if (f + 1 == frames) continue;
      const double hold = still * 0.5 * (target.hold[f] + target.hold[f + 1]);
      planar.Add<2>(hold, f, {-1, 1});
      for (const int axis : {0, 2}) {
        const double excess = points(axis, f + 1) - points(axis, f) - target.slide_m(axis, f);
        sides[axis][f] += hold * excess;
        sides[axis][f + 1] -= hold * excess;
      }
    }
    if (f + 2 < frames) {
      planar.Add<3>(smooth, f, {1, -2, 1});
      vertical.Add<3>(smooth, f, {1, -2, 1});
    }
  }
  planar.Factor();
  vertical.Factor();
  Eigen::Matrix3Xd shifts(3, frames);
  for (int axis = 0; axis < 3; ++axis) {
    (axis == 1 ? vertical : planar).Solve(&sides[axis]);
    shifts.row(axis) = sides[axis].transpose();
  }
  return shifts;
}

// How far an ankle may be from the hip: close to straight, millimetres of the ankle are centimetres of the knee.
double Reach_m(double distance_m, double length_m, double stretch) { return distance_m + stretch * std::max(0.0, length_m - distance_m); }

Eigen::Vector3d WithinReach(const Eigen::Vector3d& hip, const Eigen::Vector3d& target, double reach_m) {
  const double wanted = (target - hip).norm();
  if (wanted <= reach_m || !(wanted > 0)) return target;
  return hip + reach_m / wanted * (target - hip);
}

// One foot, and what is to become of it.
struct LockedFoot {
  LegIk leg;
  FootPath path;
  PartTarget targets[2];  // heel, ball
  Eigen::Matrix3Xd shifts;

  double reach_m(int f, const FootLockOptions& options) const {
    return Reach_m((path.ankles.col(f) - path.hips.col(f)).norm(), leg.length_m(), options.stretch);
  }
};

// How far the body comes down in every frame, so that legs that are nearly straight reach the floor with their planted feet. Of two legs
// that are short the one that asks for more counts: what it gets is enough for the other.
Eigen::VectorXd Drops(const std::vector<LockedFoot>& feet, double rate_hz, const FootLockOptions& options) {
  const int frames = static_cast<int>(feet.front().shifts.cols());
  const double smooth = std::pow(options.ease_s * rate_hz, 4);
  internal::PentadiagonalSystem system(frames);
  Eigen::VectorXd drops = Eigen::VectorXd::Zero(frames);
  for (int f = 0; f < frames; ++f) {
    double weight = 0;
    for (const LockedFoot& foot : feet) {
      const Eigen::Vector3d leg = foot.path.hips.col(f) - foot.path.ankles.col(f) - foot.shifts.col(f);
      const double length = leg.norm(), missing = length - foot.reach_m(f, options);
      if (missing <= 0 || leg.y() <= 0) continue;
      const double hold = options.level * std::max(foot.targets[0].hold[f], foot.targets[1].hold[f]);
      const double asked = hold * std::min(kLargestDrop_m, missing / std::max(kLeastUpright, leg.y() / length));
      if (asked > drops[f]) weight = hold, drops[f] = asked;
    }
    system.Add<1>(1 + weight, f, {1});
    if (f + 2 < frames) system.Add<3>(smooth, f, {1, -2, 1});
  }
  system.Factor();
  system.Solve(&drops);
  return drops.cwiseMax(0);
}

}  // namespace

void LockFeet(const FeetGeometry& feet, const PoseLayout& layout, const ContactProfile& contacts, const FootLockOptions& options,
              MotionClip* clip) {
  const int frames = clip->frame_count();
  const double rate_hz = clip->frame_rate_hz();
  std::vector<double> headings;
  for (int f = 0; f < frames; ++f) headings.push_back(layout.HeadingOf(clip->rotation(f, layout.active_joints()[0])));
  std::vector<LockedFoot> locked;
  for (int side = 0; side < 2; ++side) {
    LockedFoot& foot = locked.emplace_back(LockedFoot{LegIk(clip->skeleton(), side == 0 ? Foot::kLeft : Foot::kRight), {}, {}, {}});
    foot.path = PathOf(foot.leg, feet.heel_offset_m[side], *clip);
    for (int part = 0; part < 2; ++part) foot.targets[part] = TargetOf(side, part, feet, contacts, headings, rate_hz, options);
    foot.shifts = Shifts(foot.path, foot.targets, rate_hz, options);
    for (int f = 0; f < frames; ++f) {
      // No heel or ball comes lower than captured ones do, nor through the floor.
      const double above = std::min(foot.path.parts[0](1, f) - std::max(feet.heel_lowest_m[side], -kFloorGive_m),
                                    foot.path.parts[1](1, f) - std::max(feet.ball_lowest_m[side], -kFloorGive_m));
      foot.shifts(1, f) = std::max(foot.shifts(1, f), -above);
    }
  }
  const Eigen::VectorXd drops = Drops(locked, rate_hz, options);
  clip->root_positions().row(1) -= drops.transpose();
  for (const LockedFoot& foot : locked) {
    for (int f = 0; f < frames; ++f) {
      const Eigen::Vector3d ankle = foot.path.ankles.col(f), shift = foot.shifts.col(f);
      const Eigen::Vector3d hip = foot.path.hips.col(f) - drops[f] * Eigen::Vector3d::UnitY();
      // Most of every swing needs nothing, unless the leg is so straight that its knee might be bent back.
      const bool straight = (ankle - foot.path.hips.col(f)).norm() > kNearlyStraight * foot.leg.length_m();
      if (!straight && shift.norm() + drops[f] < kNegligible_m) continue;
      foot.leg.Solve(WithinReach(hip, ankle + shift, foot.reach_m(f, options)), std::nullopt, clip->root_positions().col(f),
                     &clip->rotation(f, 0));
    }
  }
}

}  // namespace morphograph
