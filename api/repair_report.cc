#include "api/repair_report.h"

#include "api/rounded_json.h"

namespace morphograph {

nlohmann::ordered_json RepairJson(const std::vector<std::string>& used_sensors, const RepairedReadings& repaired) {
  using nlohmann::ordered_json;
  ordered_json dead = ordered_json::array();
  for (const int sensor : repaired.dead_sensors) dead.push_back(repaired.readings.names[static_cast<std::size_t>(sensor)]);
  return {{"sensors", used_sensors},
          {"dead_sensors", dead},
          {"lost", Decimals5(repaired.lost_share)},
          {"spikes", Decimals5(repaired.spike_share)},
          {"clipped", Decimals5(repaired.clipped_share)},
          {"longest_gap", Decimals5(repaired.longest_gap_s)},
          {"notes", repaired.notes}};
}

}  // namespace morphograph
