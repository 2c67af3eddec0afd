#pragma once

#include <string>
#include <string_view>

#include "datasets/sensor_recording.h"

namespace morphograph {

/// Rate of the foot sensors that write this format; the file does not say it.
inline constexpr double kFootSensorRate_hz = 204.8;

/// CSV of inertial foot sensors with two header rows, as the gait analysis library gaitmap exports its tables: `sensor,left_sensor,right_sensor,…`, then
/// `axis,acc_x,acc_x,…` (acc_x acc_y acc_z gyr_x gyr_y gyr_z, in any order), then a row a sample with the sample's number first. Accelerations in m/s^2 with gravity, rates
/// in rad/s. A missing number is a lost sample.
/// @throws DatasetError with line and column.
SensorRecording ParseFootSensors(std::string_view text, const std::string& file, double rate_hz = kFootSensorRate_hz);

/// Whether text looks like such a file.
bool IsFootSensorText(std::string_view text);

}  // namespace morphograph
