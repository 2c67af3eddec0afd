#pragma once

#include <memory>
#include <vector>

#include "synthesis/control/residuals/control_residuals.h"

namespace morphograph {

/// A foot at a phase of a step at which it is planted, and what the foot lock will ask of it there (LockFeet).
struct PlantedMoment {
  std::shared_ptr<const JointChain> hip, ankle, ball;
  Eigen::Vector3d heel_offset_m = Eigen::Vector3d::Zero();  // in the ankle's frame
  double leg_length_m = 1;
  double phase = 0;
  double hold[2] = {0, 0};      // of heel and ball, 0 to 1
  double height_m[2] = {0, 0};  // that they are meant to have
};

/// How much of the way down to where it is meant to stand a planted foot cannot be brought, since the leg is too straight for that; 0 where
/// it can. A foot lock then lowers the body, which is a last resort: it is the walk that has to bring the pelvis lower, or step less far.
class ReachResidual : public StepResidual {
 public:
  ReachResidual(std::shared_ptr<const StepKinematics> step, std::vector<PlantedMoment> moments, double deviation_m);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::vector<PlantedMoment> moments_;
  double deviation_m_;
};

}  // namespace morphograph
