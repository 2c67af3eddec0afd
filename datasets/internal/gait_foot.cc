#include "datasets/internal/gait_foot.h"

#include <algorithm>
#include <cmath>

#include "datasets/gait_curves.h"

namespace morphograph {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kSlopeStepS = 1e-5;
constexpr double kToesRelaxProgress = 0.45;  // of the swing: toes bent at toe-off are straight again
constexpr double kSoftFloorM = 0.006;

Quaterniond Turned(double yaw_rad, double pitch_rad) {
  return Quaterniond(AngleAxisd(yaw_rad, Vector3d::UnitY()) * AngleAxisd(-pitch_rad, Vector3d::UnitX()));
}

// Foot against the floor, toe-up positive, that the joint curves give for a swing of relative length `scale`.
double TypicalPitch(double phase, double scale) {
  using namespace gait_curves;
  return scale * (kHipFlexion.AtRad(phase) - kKneeFlexion.AtRad(phase) + kAnkleDorsiflexion.AtRad(phase));
}

// max(0, x), rounded over +-width.
double SoftPositive(double x, double width) {
  if (x <= -width) return 0;
  if (x >= width) return x;
  return (x + width) * (x + width) / (4 * width);
}

}  // namespace

GaitFoot::GaitFoot(const std::vector<GaitStance>& stances, const SyntheticFoot& shape, double normal_swing_m)
    : stances_(stances), shape_(shape) {
  for (size_t i = 0; i + 1 < stances_.size(); ++i) {
    const GaitStance& from = stances_[i];
    const GaitStance& to = stances_[i + 1];
    const double scale = std::clamp(to.swing_in_m / normal_swing_m, 0.35, 1.15);
    const double swing_s = to.strike_s - from.lift_s;
    std::vector<double> times = {from.heel_off_s, from.lift_s}, pitches = {0, TypicalPitch(gait_curves::kToeOffPhase, scale)};
    for (const double progress : {0.25, 0.5, 0.75}) {
      times.push_back(from.lift_s + progress * swing_s);
      const double phase = gait_curves::kToeOffPhase + progress * (1 - gait_curves::kToeOffPhase);
      pitches.push_back(TypicalPitch(phase, scale));
    }
    times.insert(times.end(), {to.strike_s, to.flat_s});
    pitches.insert(pitches.end(), {std::max(0.0, TypicalPitch(1, scale)), 0});
    pitches_.emplace_back(times, pitches);
  }
}

int GaitFoot::StanceAt(double t_s) const {
  for (size_t i = 0; i < stances_.size(); ++i) {
    if (t_s >= stances_[i].strike_s && t_s <= stances_[i].lift_s) return static_cast<int>(i);
  }
  return -1;
}

double GaitFoot::PitchAt(int arc, double t_s) const {
  if (arc < 0 || arc >= static_cast<int>(pitches_.size())) return 0;
  return pitches_[arc].ScalarAt(t_s);
}

Vector3d GaitFoot::HeelContact(int stance) const {
  const GaitStance& at = stances_[stance];
  return Vector3d(at.ankle_m.x(), 0, at.ankle_m.y()) + Turned(at.yaw_rad, 0) * Vector3d(0, 0, -shape_.heel_behind_m);
}

Vector3d GaitFoot::Ball(int stance) const {
  const GaitStance& at = stances_[stance];
  return Vector3d(at.ankle_m.x(), shape_.ball_height_m, at.ankle_m.y()) +
         Turned(at.yaw_rad, 0) * Vector3d(0, 0, shape_.ball_ahead_m);
}

GaitFoot::Pose GaitFoot::Planted(int stance, double t_s) const {
  const GaitStance& at = stances_[stance];
  // The splines may overshoot by a hair: a heel cannot be pressed into the floor, nor lift before its time.
  const double roll = t_s < at.flat_s ? std::max(0.0, PitchAt(stance - 1, t_s)) : 0;
  const double rise = t_s > at.heel_off_s ? std::min(0.0, PitchAt(stance, t_s)) : 0;
  Pose pose;
  if (rise < 0) {
    pose.world_from_foot = Turned(at.yaw_rad, rise);
    pose.toe_up_rad = -rise;
    pose.ankle_m = Ball(stance) - pose.world_from_foot * Vector3d(0, shape_.ball_height_m - shape_.ankle_height_m, shape_.ball_ahead_m);
  } else {
    pose.world_from_foot = Turned(at.yaw_rad, roll);
    pose.ankle_m = HeelContact(stance) - pose.world_from_foot * Vector3d(0, -shape_.ankle_height_m, -shape_.heel_behind_m);
  }
  return pose;
}

void GaitFoot::PlanSwings(const SwingCurve& curve) {
  swings_.clear();
  for (int i = 0; i + 1 < static_cast<int>(stances_.size()); ++i) {
    const double from_s = stances_[i].lift_s, to_s = stances_[i + 1].strike_s;
    const Vector3d from = Planted(i, from_s).ankle_m, to = Planted(i + 1, to_s).ankle_m;
    const Vector3d from_slope = (from - Planted(i, from_s - kSlopeStepS).ankle_m) / kSlopeStepS;
    const Vector3d to_slope = (Planted(i + 1, to_s + kSlopeStepS).ankle_m - to) / kSlopeStepS;
    const Vector3d miss_from = from - curve(from_s, 0, stances_[i + 1]);
    const Vector3d miss_to = to - curve(to_s, 1, stances_[i + 1]);
    std::vector<double> times = {from_s};
    Eigen::MatrixXd values(3, 6);
    values.col(0) = from;
    for (int v = 1; v <= 4; ++v) {
      const double progress = v / 5.0, share = Smootherstep(progress);
      times.push_back(from_s + progress * (to_s - from_s));
      Vector3d via = curve(times.back(), progress, stances_[i + 1]) + (1 - share) * miss_from + share * miss_to;
      const double level = from.y() + share * (to.y() - from.y());
      via.y() = level + stances_[i + 1].foot_lift * (via.y() - level);
      values.col(v) = via;
    }
    times.push_back(to_s);
    values.col(5) = to;
    swings_.emplace_back(times, values, from_slope, to_slope);
  }
}

GaitFoot::Pose GaitFoot::KeepAboveFloor(Pose pose, double progress) const {
  const Vector3d ball = pose.ankle_m + pose.world_from_foot * Vector3d(0, shape_.ball_height_m - shape_.ankle_height_m, shape_.ball_ahead_m);
  const Quaterniond world_from_toes = pose.world_from_foot * AngleAxisd(-pose.toe_up_rad, Vector3d::UnitX());
  const Vector3d tip = ball + world_from_toes * Vector3d(0, shape_.tip_height_m - shape_.ball_height_m, shape_.toe_length_m);
  const Vector3d heel = pose.ankle_m + pose.world_from_foot * Vector3d(0, -shape_.ankle_height_m, -shape_.heel_behind_m);
  const double room = std::min({heel.y(), ball.y() - shape_.ball_height_m, tip.y() - shape_.tip_height_m});
  // Rounded in mid-swing, exact where the foot leaves and lands.
  const double soft = kSoftFloorM * std::min(1.0, 20 * progress * (1 - progress) * progress * (1 - progress)) + 1e-6;
  pose.ankle_m.y() += SoftPositive(-room, soft);
  return pose;
}

GaitFoot::Pose GaitFoot::At(double t_s) const {
  const int stance = StanceAt(t_s);
  if (stance >= 0) return Planted(stance, t_s);
  int arc = 0;
  while (t_s > stances_[arc + 1].strike_s) ++arc;
  const double from_s = stances_[arc].lift_s, to_s = stances_[arc + 1].strike_s;
  const double progress = (t_s - from_s) / (to_s - from_s);
  const double pitch = PitchAt(arc, t_s);
  const double yaw = stances_[arc].yaw_rad + Smootherstep(progress) * (stances_[arc + 1].yaw_rad - stances_[arc].yaw_rad);
  Pose pose;
  pose.ankle_m = swings_[arc].At(t_s);
  pose.world_from_foot = Turned(yaw, pitch);
  pose.toe_up_rad = std::max(0.0, -pitch) * (1 - Smootherstep(progress / kToesRelaxProgress));
  return KeepAboveFloor(pose, progress);
}

}  // namespace morphograph
