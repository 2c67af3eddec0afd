#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/skeleton.h"

namespace morphograph {

/// Accelerations of the evaluation's role joints (those that the skeleton has), by second differences of
/// world positions: norms in m/s^2, (frames - 2) x joints values, frame by frame. Empty for fewer than 3
/// frames.
std::vector<double> JointAccelerations(const Skeleton& skeleton,
                                       const std::vector<Eigen::Matrix3Xd>& joint_positions,
                                       double frame_rate_hz);

/// The same for jerk, by third differences, m/s^3. Empty for fewer than 4 frames.
std::vector<double> JointJerks(const Skeleton& skeleton, const std::vector<Eigen::Matrix3Xd>& joint_positions,
                               double frame_rate_hz);

}  // namespace morphograph
