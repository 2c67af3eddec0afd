#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"

namespace morphograph {

/// A walk to generate; every figure is a plain human one by default.
struct SyntheticGaitOptions {
  std::uint64_t seed = 1;
  double frame_rate_hz = 60;  // [10, 480]
  double stature_m = 1.75;    // [1.0, 2.2]

  int steps = 10;  // foot strikes, [2, 2000]; a walk that stops adds one step that closes the feet
  bool start_standing = true;  // else the clip begins with the third strike of a walk
  bool stop_standing = true;   // else it ends with a strike
  bool left_first = true;
  double stand_s = 0.6;        // stillness before the first and after the last movement, [0, 60]

  double speed_m_s = 1.3;      // mean of the steady steps, [0.3, 2.0]
  /// Distance between successive strikes, [0.25, 1.0]. Empty: the walk ratio of adults, step length over cadence = 0.0064 m min
  /// (Sekiya & Nagasaki 1998), scaled with stature.
  std::optional<double> step_length_m;
  std::vector<double> turns_rad;  // of the path at each step, the last repeats, |turn| <= 0.5; empty: straight
  Eigen::Vector2d start_m = Eigen::Vector2d::Zero();  // (x, z)
  double heading_rad = 0;      // 0 along +Z, pi/2 along +X

  double variation = 1;        // of step to step; 1 is human, 0 makes every step alike, [0, 3]
  double step_width_m = 0.10;  // between the lines of the ankles, [0.02, 0.4]
  double stoop_rad = 0;        // bent trunk, [-0.3, 1.0]
  double arm_swing = 1;        // scale, [0, 3]
  double foot_lift = 1;        // scale of the swing foot's clearance, [0.5, 2]
  double knee_bend_rad = 0;    // added to the standing leg's knee, [0, 0.6]
  double toe_out_rad = 0.1;    // [-0.3, 0.6]
  std::string style;           // carried into the clip

  /// Name of the field and what is wrong with it; empty when all is well.
  std::optional<std::pair<std::string, std::string>> FirstProblem() const;
};

/// What the generator knows about the walk it made.
struct SyntheticGaitTruth {
  struct Strike {
    Foot foot = Foot::kLeft;
    double time_s = 0;  // in the clip; negative or past the end where the clip was cut
    Eigen::Vector2d ankle_m = Eigen::Vector2d::Zero();  // (x, z) with the foot flat
  };
  std::vector<Strike> strikes;
  /// Seconds [from, to] in which a part of the foot does not move: heel until heel-off, ball from foot-flat until toe-off.
  struct Plant {
    Foot foot = Foot::kLeft;
    bool heel = false;  // else the ball
    double from_s = 0, to_s = 0;
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // heel: its contact point on the sole; ball: the toe joint
  };
  std::vector<Plant> plants;
};

/// A walk made of typical joint curves (gait_curves.h), planned steps and inverse kinematics, with no recording behind it.
///
/// Footprints and strike times are planned first; the pelvis follows them; its height is what the stance legs' typical knee
/// angles give, never more than they reach. A planted foot stands exactly: it rolls over the heel, lies flat, then rises about the
/// ball. Swing feet follow hip and knee curves, bent to start and end where the plan says. Trunk and arms follow their curves,
/// faded in and out with the walk. Floor y = 0. The skeleton is SyntheticSkeleton(stature_m).
///
/// The motion does not depend on the frame rate, which only samples it; same options, same clip.
/// @throws std::invalid_argument on `options.FirstProblem()`.
MotionClip GenerateGait(const SyntheticGaitOptions& options, SyntheticGaitTruth* truth = nullptr);

}  // namespace morphograph
