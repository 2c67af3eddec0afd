#include "datasets/synthetic_gait.h"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <stdexcept>

#include "datasets/gait_curves.h"
#include "datasets/internal/gait_foot.h"
#include "datasets/internal/gait_plan.h"
#include "datasets/internal/smooth_envelope.h"
#include "datasets/leg_ik.h"
#include "datasets/synthetic_skeleton.h"

namespace morphograph {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using boost::math::double_constants::degree;

constexpr double kGridHz = 200;           // of the pelvis height, which needs its neighbours in time
constexpr double kHeightSmoothingS = 0.055;
constexpr double kReliefS = 0.10;         // how early the pelvis yields to a leg that runs out of reach
constexpr double kReach = 0.994;          // of the straight leg; the soft limit of LegIk begins at 0.996
constexpr double kStandingKneeRad = 5 * degree;
constexpr double kArmAbductionRad = 9 * degree;
constexpr double kForwardLeanRad = 2.5 * degree;  // of the trunk at normal speed

Quaterniond About(const Vector3d& axis, double angle_rad) { return Quaterniond(AngleAxisd(angle_rad, axis)); }
const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

// A walk under construction: everything that the pose of a moment needs.
class Walker {
 public:
  explicit Walker(const SyntheticGaitOptions& options)
      : options_(options),
        skeleton_(SyntheticSkeleton(options.stature_m)),
        plan_(PlanGait(options)),
        legs_{LegIk(*skeleton_, Foot::kLeft), LegIk(*skeleton_, Foot::kRight)},
        feet_{PlannedFoot(0), PlannedFoot(1)} {
    for (int side = 0; side < 2; ++side) {
      thigh_m_ = skeleton_->joint(legs_[side].knee()).offset_m.norm();
      shin_m_ = skeleton_->joint(legs_[side].ankle()).offset_m.norm();
    }
    stride_scale_ = plan_.step_m / (gait_curves::kNormalStepM * options_.stature_m / gait_curves::kNormalStatureM);
    PlanPelvisHeight();
    for (int side = 0; side < 2; ++side) {
      feet_[side].PlanSwings([&](double t_s, double progress, const GaitStance& stance) {
        return SwingCurve(side, t_s, progress, stance);
      });
    }
  }

  const std::shared_ptr<const Skeleton>& skeleton() const { return skeleton_; }
  const GaitPlan& plan() const { return plan_; }
  const GaitFoot& foot(int side) const { return feet_[side]; }

  void PoseAt(double t_s, Vector3d* root_m, Quaterniond* rotations) const;

 private:
  GaitFoot PlannedFoot(int side) const {
    const double normal_swing_m = 2 * gait_curves::kNormalStepM * options_.stature_m / gait_curves::kNormalStatureM;
    return GaitFoot(plan_.stances[side], SyntheticFoot(options_.stature_m), normal_swing_m);
  }
  double Phase(int side, double t_s) const { return plan_.phase.ScalarAt(t_s) + (side == 0 ? 0.0 : 0.5); }
  double PathYaw(double t_s) const { return plan_.path.HeadingRad(plan_.progress.ScalarAt(t_s)); }
  Quaterniond Pelvis(double t_s) const;
  Vector2d PelvisOnFloor(double t_s) const {
    return plan_.path.Beside(plan_.progress.ScalarAt(t_s), plan_.sway.ScalarAt(t_s));
  }
  double StanceKneeRad(const GaitStance& stance, double t_s) const;
  double HeightFor(int side, double t_s, double leg_m) const;
  void PlanPelvisHeight();
  double PelvisHeight(double t_s) const;
  Vector3d SwingCurve(int side, double t_s, double progress, const GaitStance& stance) const;
  void PoseUpperBody(double t_s, Quaterniond* rotations) const;

  SyntheticGaitOptions options_;
  std::shared_ptr<const Skeleton> skeleton_;
  GaitPlan plan_;
  std::array<LegIk, 2> legs_;
  std::array<GaitFoot, 2> feet_;
  double thigh_m_ = 0, shin_m_ = 0, stride_scale_ = 1;
  std::vector<double> heights_;  // of the pelvis, at kGridHz
};

Quaterniond Walker::Pelvis(double t_s) const {
  const double scale = plan_.Fade(t_s) * std::clamp(stride_scale_, 0.4, 1.3);
  const double phase = Phase(0, t_s);
  // Left side forward is a negative turn about +Y, left side up a positive one about +Z.
  const double yaw = PathYaw(t_s) - gait_curves::kPelvisRotation.AtRad(phase, 1) * scale;
  const double roll = gait_curves::kPelvisObliquity.AtRad(phase, 1) * scale;
  const double tilt = gait_curves::kPelvisTilt.AtRad(phase, scale) + 0.2 * options_.stoop_rad;
  return About(kY, yaw) * About(kZ, roll) * About(kX, tilt);
}

double Walker::StanceKneeRad(const GaitStance& stance, double t_s) const {
  const double nominal_s = plan_.step_s * 1.24;
  double progress;
  if (std::isfinite(stance.strike_s) && std::isfinite(stance.lift_s)) {
    progress = (t_s - stance.strike_s) / (stance.lift_s - stance.strike_s);
  } else if (std::isfinite(stance.lift_s)) {
    progress = std::max(0.4, 1 + (t_s - stance.lift_s) / nominal_s);
  } else {
    progress = std::isfinite(stance.strike_s) ? std::min(0.6, (t_s - stance.strike_s) / nominal_s) : 0.5;
  }
  const double walking = gait_curves::kKneeFlexion.AtRad(gait_curves::kToeOffPhase * std::clamp(progress, 0.0, 1.0));
  const double fade = plan_.Fade(t_s);
  return options_.knee_bend_rad + kStandingKneeRad + fade * (walking - kStandingKneeRad);
}

// Height of the pelvis at which the hip is `leg_m` from the planted ankle.
double Walker::HeightFor(int side, double t_s, double leg_m) const {
  const int stance = feet_[side].StanceAt(t_s);
  const Vector3d ankle = feet_[side].Planted(stance, t_s).ankle_m;
  const Vector3d pelvis_to_hip = Pelvis(t_s) * skeleton_->joint(legs_[side].hip()).offset_m;
  const Vector2d across = PelvisOnFloor(t_s) + Vector2d(pelvis_to_hip.x(), pelvis_to_hip.z()) - Vector2d(ankle.x(), ankle.z());
  return ankle.y() + std::sqrt(std::max(0.01, leg_m * leg_m - across.squaredNorm())) - pelvis_to_hip.y();
}

void Walker::PlanPelvisHeight() {
  const int count = static_cast<int>(std::ceil(plan_.duration_s * kGridHz)) + 2;
  std::vector<double> wanted(count), limit(count);
  for (int i = 0; i < count; ++i) {
    const double t = i / kGridHz;
    const int stance[2] = {feet_[0].StanceAt(t), feet_[1].StanceAt(t)};
    double weight[2] = {stance[0] >= 0 ? 1.0 : 0.0, stance[1] >= 0 ? 1.0 : 0.0};
    if (stance[0] >= 0 && stance[1] >= 0) {
      // Weight passes from the trailing foot to the one that struck last.
      const GaitStance* at[2] = {&feet_[0].stances()[stance[0]], &feet_[1].stances()[stance[1]]};
      const int lead = at[0]->strike_s > at[1]->strike_s ? 0 : 1;
      const double strike = at[lead]->strike_s, lift = at[1 - lead]->lift_s;
      const bool passing = std::isfinite(strike) && std::isfinite(lift);
      weight[lead] = passing ? Smootherstep((t - strike) / (lift - strike)) : 0.5;
      weight[1 - lead] = 1 - weight[lead];
    }
    limit[i] = 10;
    for (int side = 0; side < 2; ++side) {
      if (stance[side] < 0) continue;
      const double knee = StanceKneeRad(feet_[side].stances()[stance[side]], t);
      const double leg = std::sqrt(thigh_m_ * thigh_m_ + shin_m_ * shin_m_ + 2 * thigh_m_ * shin_m_ * std::cos(knee));
      wanted[i] += weight[side] * HeightFor(side, t, leg);
    }
    // A foot that lands or lifts between two grid points counts at both.
    for (const double near_s : {t - 1 / kGridHz, t, t + 1 / kGridHz}) {
      for (int side = 0; side < 2; ++side) {
        if (feet_[side].StanceAt(near_s) < 0) continue;
        limit[i] = std::min(limit[i], HeightFor(side, near_s, kReach * (thigh_m_ + shin_m_)));
      }
    }
  }

  const std::vector<double> smooth = GaussianSmoothed(wanted, kHeightSmoothingS * kGridHz);
  std::vector<double> excess(count);
  for (int i = 0; i < count; ++i) excess[i] = std::max(0.0, smooth[i] - limit[i]);
  const std::vector<double> relief = SmoothEnvelope(excess, static_cast<int>(kReliefS * kGridHz));
  heights_.resize(count);
  for (int i = 0; i < count; ++i) heights_[i] = smooth[i] - relief[i];
}

double Walker::PelvisHeight(double t_s) const {
  // Catmull-Rom over the grid.
  const int last = static_cast<int>(heights_.size()) - 1;
  const double at = std::clamp(t_s * kGridHz, 0.0, static_cast<double>(last));
  const int i = std::min(static_cast<int>(at), last - 1);
  const double u = at - i;
  const double a = heights_[std::max(i - 1, 0)], b = heights_[i], c = heights_[i + 1], d = heights_[std::min(i + 2, last)];
  return b + u / 2 * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
}

// Ankle where typical hip and knee angles of the swing would have it, in the plane of the path.
Vector3d Walker::SwingCurve(int side, double t_s, double progress, const GaitStance& stance) const {
  const double normal_swing_m = 2 * gait_curves::kNormalStepM * options_.stature_m / gait_curves::kNormalStatureM;
  const double scale = std::clamp(stance.swing_in_m / normal_swing_m, 0.3, 1.3);
  const double phase = gait_curves::kToeOffPhase + progress * (1 - gait_curves::kToeOffPhase);
  const double hip = gait_curves::kHipFlexion.AtRad(phase, scale);
  const double knee = gait_curves::kKneeFlexion.AtRad(phase, 0.5 + 0.5 * scale);
  const Vector2d floor = PelvisOnFloor(t_s);
  const Vector3d hip_m = Vector3d(floor.x(), PelvisHeight(t_s), floor.y()) + Pelvis(t_s) * skeleton_->joint(legs_[side].hip()).offset_m;
  const Vector3d leg(0, -thigh_m_ * std::cos(hip) - shin_m_ * std::cos(hip - knee),
                     thigh_m_ * std::sin(hip) + shin_m_ * std::sin(hip - knee));
  return hip_m + About(kY, PathYaw(t_s)) * leg;
}

void Walker::PoseUpperBody(double t_s, Quaterniond* rotations) const {
  const double fade = plan_.Fade(t_s);
  const double pace = options_.speed_m_s / gait_curves::kNormalSpeedMS;
  const double phase = Phase(0, t_s);
  const double scale = fade * std::clamp(stride_scale_, 0.4, 1.3);
  // The chest turns against the pelvis; the spine shares what lies between.
  const double twist = (gait_curves::kPelvisRotation.AtRad(phase) - gait_curves::kChestRotation.AtRad(phase)) * scale;
  const double level = -gait_curves::kPelvisObliquity.AtRad(phase) * scale;
  const double lean = fade * kForwardLeanRad * pace - gait_curves::kPelvisTilt.AtRad(phase, scale);
  const double bend = 0.8 * options_.stoop_rad;  // the pelvis takes the rest
  const auto set = [&](const char* name, const Quaterniond& rotation) { rotations[skeleton_->Find(name)] = rotation; };
  set("Spine", About(kY, 0.5 * twist) * About(kZ, 0.7 * level) * About(kX, 0.5 * (lean + bend)));
  set("Spine1", About(kY, 0.5 * twist) * About(kZ, 0.3 * level) * About(kX, 0.5 * (lean + bend)));
  const double chest_yaw = -gait_curves::kChestRotation.AtRad(phase) * scale;
  set("Neck", About(kY, -0.5 * chest_yaw) * About(kX, -0.4 * options_.stoop_rad - 0.5 * lean));
  set("Head", About(kY, -0.5 * chest_yaw) * About(kX, -0.4 * options_.stoop_rad - 0.2 * lean));

  const double swing = options_.arm_swing * std::clamp(pace, 0.3, 1.6) * plan_.arm_scale.ScalarAt(t_s);
  for (const auto& [name, side] : {std::pair<std::string, int>{"Left", 0}, {"Right", 1}}) {
    const double sign = side == 0 ? 1 : -1;
    const double shoulder = fade * gait_curves::kShoulderFlexion.AtRad(Phase(side, t_s), swing) + 0.6 * options_.stoop_rad;
    const double rest = 14 * degree;
    const double elbow = rest + fade * (gait_curves::kElbowFlexion.AtRad(Phase(side, t_s), swing) - rest);
    const double down = boost::math::double_constants::half_pi - kArmAbductionRad;
    set((name + "Arm").c_str(), About(kX, -shoulder) * About(kZ, -sign * down));
    set((name + "ForeArm").c_str(), About(kY, -sign * std::max(0.05, elbow)));
  }
}

void Walker::PoseAt(double t_s, Vector3d* root_m, Quaterniond* rotations) const {
  const Vector2d floor = PelvisOnFloor(t_s);
  *root_m = Vector3d(floor.x(), PelvisHeight(t_s), floor.y());
  rotations[skeleton_->moving_root()] = Pelvis(t_s);
  PoseUpperBody(t_s, rotations);
  for (int side = 0; side < 2; ++side) {
    const GaitFoot::Pose foot = feet_[side].At(t_s);
    const Vector3d toes = foot.world_from_foot * kZ;
    // The knee points halfway between pelvis and foot.
    const double foot_yaw = std::atan2(toes.x(), toes.z()) - PathYaw(t_s);
    const double knee_yaw = 0.5 * std::remainder(foot_yaw, boost::math::double_constants::two_pi);
    rotations[legs_[side].hip()] = About(kY, knee_yaw) * About(kX, -0.5);
    rotations[legs_[side].knee()] = About(kX, 0.8);
    rotations[legs_[side].ankle()] = Quaterniond::Identity();
    legs_[side].Solve(foot.ankle_m, foot.world_from_foot, *root_m, rotations);
    rotations[legs_[side].toe()] = About(kX, -foot.toe_up_rad);
  }
}

}  // namespace

std::optional<std::pair<std::string, std::string>> SyntheticGaitOptions::FirstProblem() const {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  const struct {
    const char* name;
    double value, low, high;
  } ranges[] = {{"frame_rate_hz", frame_rate_hz, 10, 480}, {"stature_m", stature_m, 1.0, 2.2},
                {"steps", static_cast<double>(steps), 2, 2000}, {"stand_s", stand_s, 0, 60},
                {"speed_m_s", speed_m_s, 0.3, 2.0}, {"step_length_m", step_length_m.value_or(0.7), 0.25, 1.0},
                {"start_m", start_m.norm(), 0, 1e4}, {"heading_rad", heading_rad, -100, 100},
                {"variation", variation, 0, 3}, {"step_width_m", step_width_m, 0.02, 0.4},
                {"stoop_rad", stoop_rad, -0.3, 1.0}, {"arm_swing", arm_swing, 0, 3}, {"foot_lift", foot_lift, 0.5, 2},
                {"knee_bend_rad", knee_bend_rad, 0, 0.6}, {"toe_out_rad", toe_out_rad, -0.3, 0.6}};
  for (const auto& range : ranges) {
    if (within(range.value, range.low, range.high)) continue;
    return {{range.name, "is " + std::to_string(range.value) + "; must be " + std::to_string(range.low) + " to " +
                             std::to_string(range.high)}};
  }
  for (const double turn : turns_rad) {
    if (!within(turn, -0.5, 0.5)) return {{"turns_rad", "holds " + std::to_string(turn) + "; must be -0.5 to 0.5"}};
  }
  return std::nullopt;
}

MotionClip GenerateGait(const SyntheticGaitOptions& options, SyntheticGaitTruth* truth) {
  if (const auto problem = options.FirstProblem()) {
    throw std::invalid_argument("GenerateGait: " + problem->first + " " + problem->second);
  }
  // A clip out of the middle is cut from a longer walk: two strikes more at either end.
  SyntheticGaitOptions whole = options;
  const int before = options.start_standing ? 0 : 2;
  whole.steps += before + (options.stop_standing ? 0 : 2);
  if (!whole.turns_rad.empty()) whole.turns_rad.insert(whole.turns_rad.begin(), before, whole.turns_rad.front());
  const Walker walker(whole);
  const auto& strikes = walker.plan().strikes;
  const double from_s = options.start_standing ? 0 : strikes[before].time_s;
  const double to_s = options.stop_standing ? walker.plan().duration_s : strikes[before + options.steps - 1].time_s;

  const int frames = static_cast<int>(std::floor((to_s - from_s) * options.frame_rate_hz + 1e-9)) + 1;
  MotionClip clip(walker.skeleton(), options.frame_rate_hz, frames);
  clip.name = "synthetic_" + std::to_string(options.seed);
  clip.style = options.style;
  for (int f = 0; f < frames; ++f) {
    Vector3d root;
    walker.PoseAt(from_s + f / options.frame_rate_hz, &root, &clip.rotation(f, 0));
    clip.root_positions().col(f) = root;
  }

  if (truth) {
    *truth = {};
    for (SyntheticGaitTruth::Strike strike : strikes) {
      strike.time_s -= from_s;
      truth->strikes.push_back(strike);
    }
    for (int side = 0; side < 2; ++side) {
      const GaitFoot& foot = walker.foot(side);
      for (int i = 0; i < static_cast<int>(foot.stances().size()); ++i) {
        const GaitStance& stance = foot.stances()[i];
        const Foot which = side == 0 ? Foot::kLeft : Foot::kRight;
        truth->plants.push_back({which, true, stance.strike_s - from_s, stance.heel_off_s - from_s, foot.HeelContact(i)});
        truth->plants.push_back({which, false, stance.flat_s - from_s, stance.lift_s - from_s, foot.Ball(i)});
      }
    }
  }
  return clip;
}

}  // namespace morphograph
