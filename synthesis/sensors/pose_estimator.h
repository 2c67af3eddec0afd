#pragma once

#include <Eigen/Core>

#include "synthesis/sensors/motion_base.h"

namespace morphograph {

/// A method that turns readings into poses, one frame in, one frame out. Made for one stream; not safe to share between threads, while what it learned
/// from the base is (several streams may use one base).
class PoseEstimator {
 public:
  virtual ~PoseEstimator() = default;
  /// The pose of the present frame.
  /// @param reading  (3 * sensors of the base): accelerations as MotionBase::accelerations() has them, or marker positions. All finite: what was lost is
  ///   repaired before (stream_repair.h).
  virtual BasePose Next(const Eigen::VectorXd& reading) = 0;
};

}  // namespace morphograph
