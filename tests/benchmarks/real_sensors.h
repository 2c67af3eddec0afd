#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "datasets/readings.h"

namespace morphograph {

/// A sensor of the recording neura_s02: on which segment it sits.
struct BodySensor {
  const char* name;
  std::vector<std::string> markers;  // of its segment
  const char* joint;                 // of the skeleton, by role
  double aim_m_s2 = 0;               // 0: none is set
};

/// All of them.
const std::vector<BodySensor>& BodySensors();

/// Sensors and markers of one person who stands, walks, turns, walks back and stands.
struct NeuraRecording {
  Readings sensors, markers;
  int walk_first = 0, walk_last = 0;  // samples
  std::map<std::string, std::vector<double>> strikes_s, doubtful_s;  // by label
};

/// First of the three rows of a sensor or marker. @throws std::runtime_error where there is none of that name.
Eigen::Index RowOf(const Readings& readings, const std::string& name);

/// Prints how far poses from the sensors are from the markers' joint centres, by two methods, real beside simulated sensors.
/// @param data  the folder that holds bnr/.
void PrintPoses(const std::filesystem::path& data, const NeuraRecording& neura);

}  // namespace morphograph
