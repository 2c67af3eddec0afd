#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "datasets/internal/gait_plan.h"
#include "datasets/synthetic_skeleton.h"

namespace morphograph {

/// Where one foot of a planned walk is at any time.
///
/// While planted it turns about a fixed point: toe-up about the heel's contact point, toe-down about the ball. While it
/// swings, the ankle follows a spline through the given via points that leaves and lands with the velocities of those turns.
class GaitFoot {
 public:
  struct Pose {
    Eigen::Vector3d ankle_m;
    Eigen::Quaterniond world_from_foot;
    double toe_up_rad = 0;  // toes against the foot
  };
  /// Ankle where the leg's typical curves would have it, `progress` in [0, 1] through the swing to `stance`.
  using SwingCurve = std::function<Eigen::Vector3d(double t_s, double progress, const GaitStance& stance)>;

  /// @param normal_swing_m  length of the swing to which the typical curves belong.
  GaitFoot(const std::vector<GaitStance>& stances, const SyntheticFoot& shape, double normal_swing_m);

  /// Index of the stance that holds at `t_s`, or -1 in a swing.
  int StanceAt(double t_s) const;
  const std::vector<GaitStance>& stances() const { return stances_; }
  /// Pose while planted; needs no swing curves.
  Pose Planted(int stance, double t_s) const;

  void PlanSwings(const SwingCurve& curve);
  /// @pre PlanSwings was called.
  Pose At(double t_s) const;

  Eigen::Vector3d HeelContact(int stance) const;
  Eigen::Vector3d Ball(int stance) const;

 private:
  double PitchAt(int arc, double t_s) const;
  Pose KeepAboveFloor(Pose pose, double progress) const;

  std::vector<GaitStance> stances_;
  SyntheticFoot shape_;
  std::vector<CubicSpline> pitches_;  // arc i: from the heel-off of stance i to flat in stance i + 1; toe-up positive
  std::vector<CubicSpline> swings_;   // ankle from the lift of stance i to the strike of stance i + 1
};

}  // namespace morphograph
