#pragma once

#include <cstdint>
#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/placements.h"
#include "datasets/readings.h"

namespace morphograph {

inline constexpr double kGravity_m_s2 = 9.81;

/// What is wrong with a cheap sensor. All of it is off at first.
struct SensorFaults {
  double noise = 0;            // standard deviation of white noise on every value, in the reading's unit (m/s^2 or m)
  double bias = 0;             // standard deviation of a constant error of every axis, drawn once
  double mounting_rad = 0;     // standard deviation of a constant turn of every sensor about a random axis
  double range = 0;            // values are clipped at +- this; 0: not
  double loss = 0;             // chance that a sample of a sensor is lost, [0, 1)
};

/// What accelerometers on the body would read (Tautges 3): the second difference of their positions over three samples at `rate_hz`, less
/// gravity, in the sensor's axes. At rest, with Y up, [0, 9.81, 0]. The first and last sample repeat their neighbour's difference.
///
/// A second difference with step h is the true acceleration averaged under a triangle of half width h, so that rates can be compared (see
/// stream_repair.h).
/// @throws std::invalid_argument for a rate that is not positive, fewer than 3 samples, or a joint that the skeleton does not have.
Readings VirtualAccelerations(const MotionClip& clip, const std::vector<Placement>& placements, double rate_hz);

/// Positions of markers, a sample a frame of the clip. @throws std::invalid_argument for a joint that the skeleton does not have.
Readings VirtualMarkers(const MotionClip& clip, const std::vector<Placement>& placements);

/// The readings with faults, by seed; each kind of fault has its own stream of random numbers, so that turning one off leaves the others as they were.
/// @throws std::invalid_argument naming a fault that is negative, not finite, or a loss of 1 or more.
Readings WithFaults(const Readings& readings, const SensorFaults& faults, std::uint64_t seed);

}  // namespace morphograph
