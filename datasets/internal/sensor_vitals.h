#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "datasets/internal/sensor_track.h"

namespace morphograph {

inline constexpr double kGravityOfUnits_m_s2 = 9.81;
/// No sensor worn on a body measures more on an axis: 16 g, and a little for its calibration.
inline constexpr double kWidestRange_m_s2 = 17 * kGravityOfUnits_m_s2;

/// A sensor is clipped where so many samples say exactly the same on an axis, and more than gravity at rest.
inline constexpr double kLeastPlateau_m_s2 = 12;
inline constexpr int kLeastPlateauSamples = 3;

/// No marker on a body is farther from the origin.
inline constexpr double kFarthest_m = 1e4;

/// Samples that are farther apart tell nothing of a walk, whose steps take half a second.
inline constexpr double kLongestStep_s = 0.25;

/// What accelerations have to be multiplied with to be m/s^2, by how long they are in the middle (over samples, then over sensors): 1, 9.81 (they are in g) or 0.00981 (mg). 1 when it
/// is none of them.
double AccelerationUnit(const std::vector<SensorTrack>& tracks);

/// Whether the length of an acceleration can be gravity and motion together.
bool IsLikeGravity(double median_norm_m_s2);

/// On the average over a motion accelerations are gravity, but for what swinging limbs add. Of sensors all over a body one is always near it, also of runners (10.7 m/s^2 at most on the
/// recordings that this was developed on; hands and feet alone 18). More than this is told: other units pass for m/s^2 on limbs that are shaken.
inline constexpr double kMostMean_m_s2 = 20;

/// Least length of a sensor's mean, of those that show gravity; 0 without one.
double LeastMean(const std::vector<SensorTrack>& tracks);

/// The sentence that tells it.
std::string OddLengths(double least_mean_m_s2);

/// Why each sensor is of no use, in words that follow its name; empty for those that live. Accelerations in m/s^2, markers in any unit.
/// @param span_s  over which all sensors were heard.
std::vector<std::string> CausesOfDeath(const std::vector<SensorTrack>& tracks, bool markers, double span_s);

/// First and last sample of each stretch of a second or more in which the track says exactly the same.
std::vector<std::pair<std::size_t, std::size_t>> StuckRuns(const SensorTrack& track);

/// Whether a sensor of `among` other than `sensor` moves between two times.
bool OthersMove(const std::vector<SensorTrack>& tracks, const std::vector<int>& among, int sensor, double from_s, double to_s);

/// Column `centre` (may lie between columns) of values averaged under a triangle of half width `half_width` columns; at the ends what there is.
Eigen::VectorXd TriangleMean(const Eigen::MatrixXd& values, double centre, double half_width);

}  // namespace morphograph
