#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/sensor_recording.h"

namespace morphograph {

/// A raw Xsens text file: lines that tell the update rate, a line of column names, then a row a sample, between commas, semicolons or tabs. Needs PacketCounter and
/// Acc_X, Acc_Y, Acc_Z; takes Gyr_X … and Quat_q0 … where they are.
///
/// The packet counter gives the times (it counts modulo 65536), so lost packets are gaps.
struct XsensText {
  std::string name;      // as the caller gave it
  std::string file;      // for messages
  std::string text;
};

/// Sensors that recorded together, put on one time line by their packet counters: what a sensor lost while another did not is NaN. Time 0 is the first sample of all.
/// @throws DatasetError with file, line and column; for an update rate that is missing or differs between the sensors; for counters that do not meet.
SensorRecording ParseXsens(const std::vector<XsensText>& sensors);

/// Reads a file, every such file in a folder, or all whose path begins with `path` (`trial/1-1_` for `trial/1-1_lf.txt`, `trial/1-1_rf.txt`).
///
/// A sensor is called what is left of its file's name without what all files share, and without the sensor's serial number at the end. A folder must hold one
/// recording; other files in it are passed over.
SensorRecording ReadXsens(const std::filesystem::path& path);

/// Whether text looks like such a file.
bool IsXsensText(std::string_view text);

/// Names for files that recorded together, see ReadXsens(). @param stems  file names without folder and ending.
std::vector<std::string> XsensNames(const std::vector<std::string>& stems);

}  // namespace morphograph
