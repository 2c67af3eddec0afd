#include "synthesis/foot_lock.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/leg_ik.h"

namespace morphograph {
namespace {

// How much of a planted point's own rise and fall is taken out. All of it would make stances flatter than any captured one.
constexpr double kLevelling = 0.5;
constexpr double kNegligible_m = 1e-6;
constexpr double kNearlyStraight = 0.985;  // of the leg's length: knees bent by less than some 20 degrees

struct Interval {
  int first, last;
};

std::vector<Interval> IntervalsWhere(const std::vector<char>& flags, int shortest) {
  std::vector<Interval> intervals;
  const int frames = static_cast<int>(flags.size());
  for (int f = 0; f < frames; ++f) {
    if (!flags[f]) continue;
    int last = f;
    while (last + 1 < frames && flags[last + 1]) ++last;
    // A stance cut by the clip's ends may be of any length.
    if (last - f + 1 >= shortest || f == 0 || last == frames - 1) intervals.push_back({f, last});
    f = last;
  }
  return intervals;
}

// Cubic with given values and slopes at t = 0 and t = 1.
Eigen::Vector3d Hermite(double t, const Eigen::Vector3d& p0, const Eigen::Vector3d& m0, const Eigen::Vector3d& p1,
                        const Eigen::Vector3d& m1) {
  const double t2 = t * t;
  const double t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * p0 + (t3 - 2 * t2 + t) * m0 + (-2 * t3 + 3 * t2) * p1 + (t3 - t2) * m1;
}

// One foot over a whole clip: where its points are, and how far the ankle has to be moved.
class FootCorrection {
 public:
  FootCorrection(Eigen::Matrix3Xd heels, Eigen::Matrix3Xd balls, const FeetGeometry& feet, int side)
      : heels_(std::move(heels)),
        balls_(std::move(balls)),
        feet_(feet),
        side_(side),
        shift_(Eigen::Matrix3Xd::Zero(3, balls_.cols())) {}

  // Shifts inside a stance: one spot under the ball, and before and after it one under the heel.
  void Plant(const Interval& stance, const std::vector<char>& ball_planted) {
    int first = -1, last = -1;  // longest run with the ball planted
    for (int f = stance.first; f <= stance.last; ++f) {
      if (!ball_planted[f]) continue;
      int end = f;
      while (end + 1 <= stance.last && ball_planted[end + 1]) ++end;
      if (first < 0 || end - f > last - first) first = f, last = end;
      f = end;
    }
    if (first < 0) {
      Hold(heels_, feet_.heel_height_m[side_], stance.first, stance.last, stance.first, stance.last);
      return;
    }
    Hold(balls_, feet_.ball_height_m[side_], first, last, first, last);
    Follow(heels_, first, first - 1, stance.first);
    Follow(heels_, last, last + 1, stance.last);
  }

  // Shifts between two stances; either may be missing (the clip's ends).
  void EaseBetween(const Interval* before, const Interval* after, int ease) {
    const int from = before ? before->last : -1;
    const int to = after ? after->first : static_cast<int>(shift_.cols());
    const int swing = to - from;
    const int length = (before && after) ? std::min(ease, swing / 2) : ease;
    if (length < 1) return;
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    if (before) {
      const Eigen::Vector3d slope = before->last > before->first ? Eigen::Vector3d(shift_.col(from) - shift_.col(from - 1)) : zero;
      for (int i = 1; i < length && from + i < to; ++i) {
        shift_.col(from + i) = Hermite(static_cast<double>(i) / length, shift_.col(from), length * slope, zero, zero);
      }
    }
    if (after) {
      const Eigen::Vector3d slope = after->last > after->first ? Eigen::Vector3d(shift_.col(to + 1) - shift_.col(to)) : zero;
      for (int i = 1; i < length && to - i > from; ++i) {
        shift_.col(to - i) = Hermite(static_cast<double>(i) / length, shift_.col(to), -length * slope, zero, zero);
      }
    }
  }

  // Lifts a foot wherever heel or ball would come lower than captured ones do.
  void KeepAboveFloor() {
    for (int f = 0; f < shift_.cols(); ++f) {
      const double above = std::min(heels_(1, f) - feet_.heel_lowest_m[side_], balls_(1, f) - feet_.ball_lowest_m[side_]);
      shift_(1, f) = std::max(shift_(1, f), -above);
    }
  }

  // Rounds the corners where holds begin, end and change over: a kink in a shift is a kick in the leg's acceleration.
  void Smooth(double sigma_frames) {
    const int reach = static_cast<int>(std::ceil(2.5 * sigma_frames));
    const int frames = static_cast<int>(shift_.cols());
    const Eigen::Matrix3Xd sharp = shift_;
    for (int f = 0; f < frames; ++f) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double weights = 0;
      for (int i = -reach; i <= reach; ++i) {
        const double weight = std::exp(-0.5 * i * i / (sigma_frames * sigma_frames));
        sum += weight * sharp.col(std::clamp(f + i, 0, frames - 1));
        weights += weight;
      }
      shift_.col(f) = sum / weights;
    }
  }

  const Eigen::Matrix3Xd& shift() const { return shift_; }

 private:
  // Holds a point on the mean of its places over [mean_first, mean_last].
  void Hold(const Eigen::Matrix3Xd& points, double height, int first, int last, int mean_first, int mean_last) {
    Eigen::Vector3d spot = points.middleCols(mean_first, mean_last - mean_first + 1).rowwise().mean();
    const double lift = height - spot.y();
    for (int f = first; f <= last; ++f) {
      shift_.col(f) = spot - points.col(f);
      shift_(1, f) = lift + kLevelling * (spot.y() - points(1, f));
    }
  }
  // Holds a point where the shift of frame `from` puts it, over `begin` to `end` in either direction.
  void Follow(const Eigen::Matrix3Xd& points, int from, int begin, int end) {
    const Eigen::Vector3d spot = points.col(from) + shift_.col(from);
    const int step = begin <= end ? 1 : -1;
    const bool outwards = (step == 1) == (begin > from);
    if (!outwards) return;
    for (int f = begin; f != end + step; f += step) {
      shift_.col(f) = spot - points.col(f);
      shift_(1, f) = shift_(1, from);
    }
  }

  Eigen::Matrix3Xd heels_, balls_;
  const FeetGeometry& feet_;
  int side_;
  Eigen::Matrix3Xd shift_;
};

}  // namespace

void LockFeet(const FeetGeometry& feet, const Eigen::Matrix4Xd& contacts, const FootLockOptions& options, MotionClip* clip) {
  const int frames = clip->frame_count();
  const int shortest = static_cast<int>(std::lround(options.shortest_s * clip->frame_rate_hz()));
  const int ease = std::max(1, static_cast<int>(std::lround(options.ease_s * clip->frame_rate_hz())));
  const LegIk legs[2] = {LegIk(clip->skeleton(), Foot::kLeft), LegIk(clip->skeleton(), Foot::kRight)};

  Eigen::Matrix3Xd hips[2], heels[2], balls[2], ankles[2];
  for (int side = 0; side < 2; ++side) {
    hips[side].resize(3, frames);
    heels[side].resize(3, frames);
    balls[side].resize(3, frames);
    ankles[side].resize(3, frames);
  }
  for (int f = 0; f < frames; ++f) {
    for (int side = 0; side < 2; ++side) {
      const LegPlace leg = legs[side].Place(clip->root_positions().col(f), clip->rotations(f));
      hips[side].col(f) = leg.hip_m;
      ankles[side].col(f) = leg.ankle_m;
      balls[side].col(f) = leg.toe_m;
      heels[side].col(f) = leg.ankle_m + leg.world_from_foot * feet.heel_offset_m[side];
    }
  }

  for (int side = 0; side < 2; ++side) {
    std::vector<char> planted(frames), ball_planted(frames);
    for (int f = 0; f < frames; ++f) {
      ball_planted[f] = contacts(2 * side + 1, f) > options.planted_chance;
      planted[f] = ball_planted[f] || contacts(2 * side, f) > options.planted_chance;
    }
    const std::vector<Interval> stances = IntervalsWhere(planted, shortest);
    FootCorrection correction(heels[side], balls[side], feet, side);
    for (const Interval& stance : stances) correction.Plant(stance, ball_planted);
    for (size_t i = 0; i <= stances.size(); ++i) {
      correction.EaseBetween(i > 0 ? &stances[i - 1] : nullptr, i < stances.size() ? &stances[i] : nullptr, ease);
    }
    correction.KeepAboveFloor();
    correction.Smooth(options.corner_s * clip->frame_rate_hz());
    for (int f = 0; f < frames; ++f) {
      const Eigen::Vector3d shift = correction.shift().col(f);
      // Most of every swing needs nothing, unless the leg is so straight that its knee might be bent back.
      const bool straight = (ankles[side].col(f) - hips[side].col(f)).norm() > kNearlyStraight * legs[side].length_m();
      if (!straight && shift.squaredNorm() < kNegligible_m * kNegligible_m) continue;
      legs[side].Solve(ankles[side].col(f) + shift, std::nullopt, clip->root_positions().col(f), &clip->rotation(f, 0));
    }
  }
}

}  // namespace morphograph
