#include "primitives/motion_primitive.h"

#include <cmath>
#include <stdexcept>

namespace morphograph {

StepShape MotionPrimitive::Shape(const Eigen::VectorXd& latent) const {
  if (latent.size() != reduction.components()) {
    throw std::invalid_argument("MotionPrimitive::Shape: latent has " + std::to_string(latent.size()) + " values, " + name +
                                " has " + std::to_string(reduction.components()) + " components");
  }
  const Eigen::VectorXd vector = reduction.mean + (reduction.basis * latent.cast<float>()).cast<double>();
  const Eigen::Index pose_values = vector.size() - kTimingValues;
  StepShape shape;
  shape.poses = vector.head(pose_values).reshaped(pose_values / kPhaseSamples, kPhaseSamples);
  shape.duration_s = std::exp(vector[pose_values]);
  shape.log_slopes = vector.tail(kWarpKnots);
  return shape;
}

}  // namespace morphograph
