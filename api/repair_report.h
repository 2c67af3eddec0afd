#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/stream_repair.h"

namespace morphograph {

/// What was wrong with readings and what was done about it, for reports: the sensors that were used, dead ones, shares of samples, the longest gap (s), notes.
nlohmann::ordered_json RepairJson(const std::vector<std::string>& used_sensors, const RepairedReadings& repaired);

}  // namespace morphograph
