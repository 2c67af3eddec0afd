#pragma once

#include <Eigen/Core>

namespace morphograph {

/// Zero-phase low-pass of every row of `samples` (channels x frames): a second-order Butterworth filter run
/// forward and backward, the ends extended by point reflection so that neither value nor slope jumps there.
///
/// Each pass has gain 1/sqrt(2) at `cutoff_hz`, both together 1/2. Returns the samples unchanged where the
/// cutoff is not below half of the frame rate or there are fewer than two frames.
/// @throws std::invalid_argument when a rate is not positive.
Eigen::MatrixXd LowPass(const Eigen::MatrixXd& samples, double frame_rate_hz, double cutoff_hz);

}  // namespace morphograph
