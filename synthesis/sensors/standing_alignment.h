#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "synthesis/sensors/worn_sensors.h"

namespace morphograph {

/// When a body stood, seconds after the first reading.
struct StandingPhase {
  double from_s = 0, to_s = 0;
};

/// What alignment is asked for.
struct AlignmentRequest {
  std::optional<StandingPhase> standing;  // empty: found in the readings (FindStanding)
};

/// How askew sensors are expected to be worn, standard deviation.
inline constexpr double kAskew_rad = 0.35;
/// Share of a tilt found by standing that is taken, [0, 1].
inline double TiltTrust(double spread_rad) { return kAskew_rad * kAskew_rad / (kAskew_rad * kAskew_rad + spread_rad * spread_rad); }

/// How a sensor was worn, against where it was told to sit.
struct WornTurn {
  Eigen::Quaterniond told_from_worn = Eigen::Quaterniond::Identity();  // what its readings are turned by
  double delay_s = 0;     // how much later than the other sensors' its readings come
  double turn_rad() const { return 2 * std::acos(std::min(1.0, std::abs(told_from_worn.w()))); }
};

/// Sensors as they were found to be worn.
struct SensorTurns {
  StandingPhase standing;
  bool told = false;       // the phase was
  bool guessed = false;    // the recordings hold no standing: how sensors read then is a guess (WornSensors)
  std::vector<WornTurn> sensors;
};

/// The longest stretch of a second or more in which all sensors lie still: what they read is as long as gravity and does not change, apart from noise of up to 1.2 m/s^2.
/// @param readings  (3 * sensors x samples) at a steady rate, finite.
std::optional<StandingPhase> FindStanding(const Eigen::MatrixXd& readings, double rate_hz);

/// How far sensors are from lying still between two times: root mean square, m/s^2, of each about its mean, under a 3 Hz low-pass. FindStanding() allows kMostUnrest_m_s2.
/// @throws std::invalid_argument for a phase that is not within the readings, or shorter than half a second.
Eigen::VectorXd UnrestOf(const Eigen::MatrixXd& readings, double rate_hz, const StandingPhase& phase);
inline constexpr double kMostUnrest_m_s2 = 1.2;

/// Turns every sensor by the smallest turn that brings what it reads while its wearer stands towards what it would read where it is told to sit. So gravity gives the tilt; turns about the vertical stay.
///
/// How sensors read on a standing body is not known equally well: feet stand flat on the floor, arms hang as they like. So a sensor goes the share TiltTrust() of that turn, as a normal
/// distribution of how askew sensors are (kAskew_rad) and one of what they should read (WornSensors::spread_rad) have it.
/// @param phase  as UnrestOf() takes it.
SensorTurns AlignByStanding(const WornSensors& worn, const Eigen::MatrixXd& readings, double rate_hz, const StandingPhase& phase);

/// What standing leaves open, from the motion: turns every sensor, and shifts it in time, so that it agrees best with what it would read on a motion that was reconstructed from the readings as they were
/// aligned so far. Both are closed forms over the samples outside of the standing phase: Wahba's problem, and the highest correlation of lengths. Of the turn, that about the vertical of the standing body
/// is taken whole, that across it as far as standing was not trusted. Where a sensor hardly agrees (a correlation below 0.5) its time stays.
/// @param expected  what sensors in the told places read on that motion, as `readings` in size.
void AlignByMotion(const WornSensors& worn, const Eigen::MatrixXd& readings, const Eigen::MatrixXd& expected, double rate_hz, SensorTurns* turns);

/// Readings as the sensors would have given them in the told places: turned, and shifted by their delays (linear interpolation; the ends repeat).
Eigen::MatrixXd AlignedReadings(const Eigen::MatrixXd& readings, double rate_hz, const SensorTurns& turns);

}  // namespace morphograph
