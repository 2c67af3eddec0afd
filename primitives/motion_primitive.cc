#include "primitives/motion_primitive.h"

#include <cmath>
#include <stdexcept>

namespace morphograph {

namespace {

void CheckLatent(const MotionPrimitive& primitive, const Eigen::VectorXd& latent) {
  if (latent.size() == primitive.reduction.components()) return;
  throw std::invalid_argument("MotionPrimitive: latent has " + std::to_string(latent.size()) + " values, " + primitive.name + " has " +
                              std::to_string(primitive.reduction.components()) + " components");
}

}  // namespace

StepShape MotionPrimitive::Shape(const Eigen::VectorXd& latent) const {
  CheckLatent(*this, latent);
  const Eigen::VectorXd vector = reduction.mean + (reduction.basis * latent.cast<float>()).cast<double>();
  const Eigen::Index pose_values = vector.size() - kTimingValues;
  StepShape shape;
  shape.poses = vector.head(pose_values).reshaped(pose_values / kPhaseSamples, kPhaseSamples);
  shape.duration_s = std::exp(vector[pose_values]);
  shape.log_slopes = vector.tail(kWarpKnots);
  return shape;
}

ContactProfile MotionPrimitive::Contacts(const Eigen::VectorXd& latent) const {
  if (latent.size() == 0 || contact_map.size() == 0) return contacts;
  CheckLatent(*this, latent);
  ContactProfile told = contacts + (contact_map * latent.cast<float>()).cast<double>().reshaped(kContactRows, kPhaseSamples);
  told.topRows<kFootParts>() = told.topRows<kFootParts>().cwiseMax(0).cwiseMin(1);
  return told;
}

}  // namespace morphograph
