#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>

#include "primitives/motion_primitive.h"

namespace morphograph {

/// Steps of one mixture component of a primitive as what they are: a linear map from the whitened latent to poses and timing. Not safe
/// to share between threads (the part for whole poses is made when it is first asked for).
class StepModel {
 public:
  /// value = offset + by_latent w.
  struct Map {
    Eigen::VectorXd offset;
    Eigen::MatrixXd by_latent;  // (values x components)
  };

  /// @param primitive  must outlive the model.
  StepModel(const MotionPrimitive& primitive, int component);

  int dimension() const { return static_cast<int>(timing_.by_latent.cols()); }
  /// Log duration (s), then the log slopes of the warp.
  const Map& timing() const { return timing_; }
  /// Channels of the root alone, (6), at a phase; the first and the last pose of the margins stay beyond them.
  Map Root(double phase) const;
  /// Its derivative by phase.
  Map RootRate(double phase) const;
  /// The same for all channels of a pose.
  Map Pose(double phase) const;
  Map PoseRate(double phase) const;
  /// As Pose(), of a phase that will be asked for again: it is kept, for as long as the model lives. For one thread, as KinematicsCache is.
  const Map& KeptPose(double phase) const;

 private:
  Map Rows(Eigen::Index first, Eigen::Index count) const;

  const MotionPrimitive& primitive_;
  const MixtureComponent& component_;
  Eigen::Index channels_;
  Map timing_;
  Map root_;                         // (6 * samples)
  mutable std::optional<Map> full_;  // (channels * samples)
  mutable std::map<double, Map> kept_;
};

}  // namespace morphograph
