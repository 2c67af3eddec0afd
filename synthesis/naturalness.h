#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/skeleton.h"

namespace morphograph {

/// Forward differences D(F_i, F_i+1) of the weighted frame distance, Du Eq. 3.1 and 4.5.
///
/// D is a sum of squared distances, so it grows with the square of the time between frames: compare clips at
/// one frame rate only (the evaluation uses 30 fps).
/// @param joint_positions  a matrix (3 x joints) a frame, metres.
/// @return frames - 1 values, m^2. @throws std::invalid_argument for fewer than 2 frames.
std::vector<double> FrameDifferences(const Skeleton& skeleton,
                                     const std::vector<Eigen::Matrix3Xd>& joint_positions);

/// Var D(F_i, F_i+1), Du Eq. 4.6, m^4; population variance, 0 for a single value.
/// @throws std::invalid_argument when there is no value.
double NaturalnessVariance(const std::vector<double>& frame_differences);

}  // namespace morphograph
