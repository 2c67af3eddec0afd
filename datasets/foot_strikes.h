#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace morphograph {

/// Stretches (first and last sample) of at least `least_s` in which a sensor lies still: its reading is as long as gravity and does not change. A planted foot's sensor does so in mid-stance, every
/// sensor of a standing body does.
/// @param accelerations  (3 x samples), m/s^2 with gravity, all finite, steady rate (RepairStream()).
std::vector<std::pair<int, int>> StillPhases(const Eigen::Matrix3Xd& accelerations, double rate_hz, double least_s);

/// When a foot strikes the floor, by a sensor on it: seconds after the first sample, rising.
///
/// A strike lies between two phases in which the foot is planted, in the last 0.3 s before the second. There it is where the change of the acceleration (jerk) first rises to a peak of at least 0.6 of its largest:
/// the moment at which it has half of that peak's height. Landings without a blow (feet that glide or turn onto the floor) are found late, with the slap of the sole.
/// @throws std::invalid_argument for a rate that is not positive.
std::vector<double> FootStrikeTimes(const Eigen::Matrix3Xd& accelerations, double rate_hz);

}  // namespace morphograph
