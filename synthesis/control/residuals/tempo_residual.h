#pragma once

#include <memory>

#include "synthesis/control/residuals/control_residuals.h"

namespace morphograph {

/// How far the log slopes of a step's time warp are beyond those that 99 of 100 steps of its kind have, each to either side; 0 within. They say how a step hurries and
/// waits: what a bend asks for could be had by a leap of a tenth of a second between two steps that wait, and no walker leaps so.
class TempoResidual : public StepResidual {
 public:
  explicit TempoResidual(std::shared_ptr<const StepKinematics> step);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;
};

}  // namespace morphograph
