#pragma once

#include <memory>

#include "synthesis/control/residuals/control_residuals.h"
#include "synthesis/control/swing_range.h"

namespace morphograph {

/// How far a step's swing is beyond what swings keep to, in speed and in height at each phase of it; 0 within. A step that a term pushes goes where the sum of squares of
/// its whole latent is least, and may well do so by a swing that no walker makes: of 50 directions one is 5 deviations off, and the whole hardly farther out than others.
class SwingResidual : public StepResidual {
 public:
  SwingResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> ball, const SwingRange& range);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::shared_ptr<const JointChain> ball_;
  SwingRange range_;
};

}  // namespace morphograph
