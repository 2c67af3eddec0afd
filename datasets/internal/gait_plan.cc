#include "datasets/internal/gait_plan.h"

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <random>

#include "datasets/gait_curves.h"

namespace morphograph {
namespace {

using Eigen::Vector2d;

constexpr double kGrainM = 0.005;        // of the tabulated path
constexpr double kWalkRatio = 0.0064;    // m min, Sekiya & Nagasaki 1998
constexpr double kShiftS = 0.45;         // weight shift before the first lift
constexpr double kSettleS = 0.50;        // after the closing strike
constexpr double kAheadAtStrike = 0.02;  // of the pelvis, in step lengths
constexpr double kStandWidthM = 0.17;    // between the ankles when standing

// Standard deviations of one step at variation 1.
constexpr double kTimeNoise = 0.02, kLengthNoise = 0.025, kWidthNoiseM = 0.012, kYawNoise = 0.03, kLiftNoise = 0.08,
                 kArmNoise = 0.06, kSwayNoise = 0.08;

// A normal draw, cut at two deviations, so that no step leaves what a leg can do.
class Noise {
 public:
  Noise(std::uint64_t seed, double variation) : rng_(seed), variation_(variation) {}
  double operator()(double deviation) {
    return variation_ * deviation * std::clamp(normal_(rng_), -2.0, 2.0);
  }

 private:
  std::mt19937_64 rng_;
  boost::random::normal_distribution<double> normal_{0, 1};
  double variation_;
};

// Both feet on the floor after a strike, as a fraction of the step: about a quarter at 1.2 m/s, less when faster.
double DoubleSupport(double speed_m_s) { return std::clamp(0.42 - 0.14 * speed_m_s, 0.12, 0.40); }

}  // namespace

GaitPath::GaitPath(const std::vector<double>& knots_m, const std::vector<double>& headings_rad, const Vector2d& start_m)
    : heading_(knots_m, headings_rad), first_m_(knots_m.front()) {
  const int count = static_cast<int>(std::ceil((knots_m.back() - first_m_) / kGrainM)) + 2;
  points_.resize(2, count);
  points_.col(0) = start_m;
  for (int i = 1; i < count; ++i) {
    const double heading = HeadingRad(first_m_ + (i - 0.5) * kGrainM);  // midpoint rule
    points_.col(i) = points_.col(i - 1) + kGrainM * Vector2d(std::sin(heading), std::cos(heading));
  }
}

Vector2d GaitPath::PointAt(double s_m) const {
  const double at = (s_m - first_m_) / kGrainM;
  const int cell = std::clamp(static_cast<int>(std::floor(at)), 0, static_cast<int>(points_.cols()) - 2);
  return points_.col(cell) + (at - cell) * (points_.col(cell + 1) - points_.col(cell));
}

Vector2d GaitPath::Beside(double s_m, double left_m) const {
  const double heading = HeadingRad(s_m);
  return PointAt(s_m) + left_m * Vector2d(std::cos(heading), -std::sin(heading));
}

double GaitPlan::Fade(double t_s) const {
  return Smootherstep((t_s - fade_in_s[0]) / (fade_in_s[1] - fade_in_s[0])) *
         (1 - Smootherstep((t_s - fade_out_s[0]) / (fade_out_s[1] - fade_out_s[0])));
}

GaitPlan PlanGait(const SyntheticGaitOptions& options) {
  GaitPlan plan;
  const double ratio = kWalkRatio * options.stature_m / gait_curves::kNormalStatureM;
  plan.step_m = options.step_length_m.value_or(std::sqrt(options.speed_m_s * 60 * ratio));
  plan.step_s = plan.step_m / options.speed_m_s;
  const double overlap = DoubleSupport(options.speed_m_s);
  const int steps = options.steps;
  Noise noise(options.seed, options.variation);

  // Step k (0-based) strikes at time[k] and arc length at[k]; the last one closes the feet.
  const int count = steps + 1;
  std::vector<double> time(count), at(count), both_s(count);
  const double begin_s = options.stand_s;
  const double first_lift_s = begin_s + kShiftS;
  time[0] = first_lift_s + 1.05 * (1 - overlap) * plan.step_s;
  at[0] = 0.72 * plan.step_m;
  for (int k = 1; k < count; ++k) {
    const bool closing = k == steps;
    const double slower = k == 1 || k + 1 == steps ? 1.06 : closing ? 1.12 : 1.0;
    const double shorter = k == 1 ? 0.94 : k + 1 == steps ? 0.80 : 1.0;
    time[k] = time[k - 1] + plan.step_s * slower * (1 + noise(kTimeNoise));
    at[k] = at[k - 1] + (closing ? 0.0 : plan.step_m * shorter * (1 + noise(kLengthNoise)));
  }
  for (int k = 0; k < count; ++k) both_s[k] = overlap * plan.step_s * (1 + noise(2 * kTimeNoise));

  // The path turns between one strike's arc length and the next.
  std::vector<double> knots = {-plan.step_m, 0}, headings = {options.heading_rad, options.heading_rad};
  double heading = options.heading_rad;
  for (int k = 0; k < steps; ++k) {
    if (!options.turns_rad.empty()) {
      heading += options.turns_rad[std::min<size_t>(static_cast<size_t>(k), options.turns_rad.size() - 1)];
    }
    knots.push_back(at[k]);
    headings.push_back(heading);
  }
  knots.push_back(at[steps - 1] + plan.step_m);
  headings.push_back(heading);
  plan.path = GaitPath(knots, headings, Vector2d::Zero());
  const Vector2d moved = options.start_m - plan.path.PointAt(0);
  plan.path = GaitPath(knots, headings, moved);

  // Footprints.
  const auto side_of = [&](int k) { return (k % 2 == 0) == options.left_first ? Foot::kLeft : Foot::kRight; };
  const auto left = [](Foot foot) { return foot == Foot::kLeft ? 1.0 : -1.0; };
  const double stand_half = std::max(kStandWidthM * options.stature_m / gait_curves::kNormalStatureM, options.step_width_m) / 2;
  const double step_half = options.step_width_m / 2;
  for (const Foot foot : {Foot::kLeft, Foot::kRight}) {
    GaitStance stance;
    stance.ankle_m = plan.path.Beside(0, left(foot) * stand_half);
    stance.yaw_rad = plan.path.HeadingRad(0) + left(foot) * options.toe_out_rad;
    plan.stances[static_cast<int>(foot)].push_back(stance);
  }
  const double stance_s = plan.step_s * (1 + overlap);
  for (int k = 0; k < count; ++k) {
    const Foot foot = side_of(k);
    std::vector<GaitStance>& stances = plan.stances[static_cast<int>(foot)];
    GaitStance& before = stances.back();
    before.lift_s = k == 0 ? first_lift_s : time[k - 1] + both_s[k - 1];
    before.heel_off_s = before.lift_s - 0.42 * stance_s;
    if (std::isinf(before.strike_s)) before.heel_off_s = before.lift_s - 0.30 * stance_s;
    before.heel_off_s = std::max(before.heel_off_s, before.flat_s + 0.02);

    GaitStance stance;
    stance.strike_s = time[k];
    stance.flat_s = time[k] + 0.14 * stance_s;
    const bool closing = k == steps;
    // Feet come together at the end as far apart as they stood at the start.
    const double half = closing ? 2 * stand_half - step_half : std::max(step_half + noise(kWidthNoiseM), 0.01);
    stance.ankle_m = plan.path.Beside(at[k], left(foot) * half);
    stance.yaw_rad = plan.path.HeadingRad(at[k]) + left(foot) * (options.toe_out_rad + noise(kYawNoise));
    stance.swing_in_m = (stance.ankle_m - before.ankle_m).norm();
    stance.foot_lift = options.foot_lift * (1 + noise(kLiftNoise));
    stances.push_back(stance);
    plan.strikes.push_back({foot, stance.strike_s, stance.ankle_m});
  }

  // The pelvis: a little ahead of halfway between the feet at each strike (the trailing heel has risen by then), and in the middle of
  // double support over the line between them; towards the standing foot from there to the next.
  const double ahead_m = kAheadAtStrike * plan.step_m;
  const double sway_m = 0.012 + 0.22 * step_half;
  std::vector<double> progress_t = {begin_s}, progress = {0}, sway_t = {begin_s}, sway = {0};
  const double first_stance_side = -left(side_of(0));
  sway_t.push_back((first_lift_s + time[0]) / 2 - 0.05);
  sway.push_back(first_stance_side * 0.62 * stand_half);
  for (int k = 0; k < count; ++k) {
    const double middle = time[k] + both_s[k] / 2;
    const double behind = k == 0 ? 0.0 : at[k - 1];
    if (k < steps) {
      progress_t.push_back(time[k]);
      progress.push_back((behind + at[k]) / 2 + ahead_m);
      sway_t.push_back(middle);
      sway.push_back(0);
      const double next_s = k + 1 < count ? time[k + 1] : time[k] + plan.step_s;
      sway_t.push_back((time[k] + both_s[k] + next_s) / 2);
      const double scale = k + 1 == steps ? 1.4 : 1.0;  // the closing step is slower and hangs longer over its foot
      sway.push_back(left(side_of(k)) * scale * sway_m * (1 + noise(kSwayNoise)));
    } else {
      const double end_s = time[k] + kSettleS;
      const double final_left = left(side_of(k)) * (stand_half - step_half);  // between the two feet
      progress_t.push_back(end_s);
      progress.push_back(at[k]);
      sway_t.push_back(end_s);
      sway.push_back(final_left);
      plan.duration_s = end_s + options.stand_s;
    }
  }
  plan.progress = CubicSpline(progress_t, progress);
  plan.sway = CubicSpline(sway_t, sway);

  std::vector<double> phase_t = {time[0] - plan.step_s}, phase, arms;
  const double first_phase = options.left_first ? 0.0 : 0.5;
  phase.push_back(first_phase - 0.5);
  arms.push_back(1);
  for (int k = 0; k < count; ++k) {
    phase_t.push_back(time[k]);
    phase.push_back(first_phase + 0.5 * k);
    arms.push_back(1 + noise(kArmNoise));
  }
  const Eigen::VectorXd rate = Eigen::VectorXd::Constant(1, 0.5 / plan.step_s);
  plan.phase = CubicSpline(phase_t, Eigen::Map<const Eigen::RowVectorXd>(phase.data(), count + 1), rate, rate);
  plan.arm_scale = CubicSpline(phase_t, arms);
  plan.fade_in_s[0] = begin_s;
  plan.fade_in_s[1] = time[std::min(1, steps - 1)];
  plan.fade_out_s[0] = std::max(time[steps - 1] - 0.2 * plan.step_s, plan.fade_in_s[1]);
  plan.fade_out_s[1] = time[steps] + kSettleS;
  return plan;
}

}  // namespace morphograph
