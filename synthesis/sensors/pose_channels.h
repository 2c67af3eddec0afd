#pragma once

#include <Eigen/Core>

#include "synthesis/sensors/motion_base.h"

namespace morphograph {

/// Poses of a base as vectors between which Euclidean distances mean something: about the root mean square distance of the joints, metres.
///
/// A rotation counts for the distance that it moves the joints below it (as PoseLayout::ChannelWeights weighs), a step for what it is worth over
/// a tenth of a second, height as it is. (channels) = rotations, then step, then height.
class PoseChannels {
 public:
  explicit PoseChannels(const MotionBase& base);

  Eigen::Index size() const { return scales_.size(); }
  Eigen::VectorXd Vector(const BasePose& pose) const;
  BasePose Pose(const Eigen::VectorXd& vector) const;
  /// (channels x frames) of the whole base, single precision.
  Eigen::MatrixXf Vectors(const MotionBase& base) const;

 private:
  Eigen::VectorXd scales_;
};

}  // namespace morphograph
