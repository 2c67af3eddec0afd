#pragma once

#include <string>
#include <vector>

#include "datasets/readings.h"
#include "datasets/readings_reader.h"

namespace morphograph {

struct StreamRepairOptions {
  ReadingsKind kind = ReadingsKind::kAccelerations;
  double rate_hz = 0;              // of the result, [1, 1000]; 0: that of the fastest sensor
  double cutoff_hz = 0;            // of a zero-phase low-pass (low_pass.h) before the rate is changed; 0: none
  double longest_bridge_s = 0.08;  // gaps up to this are bridged by a cubic
  double told_gap_s = 0.25;        // longer ones are told one by one
};

/// Readings at a steady rate without holes, and what was wrong with them.
struct RepairedReadings {
  Readings readings;              // all finite; rows of dead sensors are 0
  double rate_hz = 0;
  std::vector<std::string> notes;  // what was lost, where, and what was done: one sentence each
  std::vector<int> dead_sensors;   // rising; to be left out by the caller
  // Of living sensors:
  double lost_share = 0;           // samples that never came, of those due
  double spike_share = 0;          // samples that were replaced, of those that came
  double clipped_share = 0;        // samples on a plateau at the sensor's range
  double longest_gap_s = 0;
  double unit_factor = 1;          // what the values were multiplied with to be m/s^2 or metres
};

/// Brings readings with irregular time stamps, lost packets and wild values to a steady rate (Xie 2009, 4.2 and 4.3).
///
/// 1. *Units*: lengths of accelerations near 1 or 1000 instead of 9.81 are g or mg, bodies of 180 or 1800 units' height are in cm or mm; scaled, and told.
/// 2. *Dead sensors*: silent, constant while others move, or without gravity (on average not near 9.81 m/s^2, or pointing nowhere, as noise does).
///    Sensors that stop in the middle (one value for a second while others move) are lost from there on.
/// 3. *Spikes*: one or two samples that stand out of their neighbours by far more than the sensor's samples usually do, while the neighbours agree; and what no body sensor's range
///    holds (17 g). They are replaced as lost ones.
/// 4. *Gaps* of a sensor: short ones are bridged by a cubic through the samples around, longer ones go from both edges to the sensor's mean (markers: straight across). On walking feet a cubic
///    is nearer to the truth up to about 5 samples at 100 Hz, the mean beyond.
/// 5. *Clipping* is told, not undone.
/// 6. *Rate*: every sensor is read off at common times. To a lower rate B, accelerations are averaged under a triangle of half width 1/B: that is what the second difference of positions at
///    rate B is of the accelerations at a higher one (exactly so when B divides it), so that the result compares with MotionBase::accelerations(). To a higher rate, they are
///    interpolated. Markers are interpolated either way.
///
/// @throws DatasetError (with `source` as the file) when nothing can be made of them: fewer than 3 samples, no living sensor (each is named), time stamps over more than a day or
///   with hardly anything between them.
/// @throws std::invalid_argument for options out of range or times that do not rise.
RepairedReadings RepairStream(const Readings& readings, const StreamRepairOptions& options = {}, const std::string& source = "readings");

}  // namespace morphograph
