#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "datasets/internal/cubic_spline.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {

/// Where the walk leads: a curve on the floor by arc length. Straight on beyond its ends.
class GaitPath {
 public:
  GaitPath() = default;
  /// @param knots_m, headings_rad  heading at arc lengths; smooth in between.
  GaitPath(const std::vector<double>& knots_m, const std::vector<double>& headings_rad, const Eigen::Vector2d& start_m);

  double HeadingRad(double s_m) const { return heading_.ScalarAt(s_m); }
  Eigen::Vector2d PointAt(double s_m) const;               // (x, z)
  Eigen::Vector2d Beside(double s_m, double left_m) const;  // `left_m` to the left of the path

 private:
  CubicSpline heading_;
  double first_m_ = 0;
  Eigen::Matrix2Xd points_;  // every kGrainM
};

/// One time that a foot stands, from strike to lift. Standing at the start and the end have no strike and no lift.
struct GaitStance {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double strike_s = -kNever;
  double flat_s = -kNever;      // end of the roll over the heel
  double heel_off_s = kNever;   // start of the rise about the ball
  double lift_s = kNever;
  Eigen::Vector2d ankle_m = Eigen::Vector2d::Zero();  // (x, z), foot flat
  double yaw_rad = 0;
  double swing_in_m = 0;   // length of the swing that led here
  double foot_lift = 1;    // of that swing
};

/// Footprints, times and the course of the pelvis, planned before any joint moves.
struct GaitPlan {
  std::array<std::vector<GaitStance>, 2> stances;  // per foot, in time order
  std::vector<SyntheticGaitTruth::Strike> strikes;  // in time order, the closing one last
  GaitPath path;
  CubicSpline progress;   // arc length of the pelvis over time
  CubicSpline sway;       // pelvis to the left of the path over time, metres
  CubicSpline phase;      // gait cycles over time; whole at left strikes, half at right ones
  CubicSpline arm_scale;  // over time
  double fade_in_s[2] = {}, fade_out_s[2] = {};  // the walk's curves fade in and out over these
  double duration_s = 0;
  double step_s = 0, step_m = 0;  // nominal, of a steady step

  /// 0 standing, 1 walking.
  double Fade(double t_s) const;
};

GaitPlan PlanGait(const SyntheticGaitOptions& options);

}  // namespace morphograph
