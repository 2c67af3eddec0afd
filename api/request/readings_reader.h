#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/request/findings.h"
#include "api/request/object_reader.h"
#include "datasets/placements.h"
#include "datasets/readings.h"

namespace morphograph {

/// Readings as they stand in a request, and where their sensors sit.
struct PlacedReadings {
  Readings readings;
  std::vector<Placement> placements;  // one a sensor, in order
};

/// Reads the member "placements": one or more, each with a name of its own.
std::vector<Placement> ReadPlacementList(ObjectReader* reader, Findings* findings);

/// Reads `{"rate", "placements", "readings"}`: a row a sample, three numbers a sensor, null for what was lost; "times" in seconds may stand in place of "rate".
/// @param tolerance, weight  of the readings on a clip (m/s^2), where a request may have them; they stay as they are where they are absent.
PlacedReadings ReadPlacedReadings(const nlohmann::json& object, const std::string& pointer, Findings* findings, double* tolerance = nullptr,
                                  double* weight = nullptr);

}  // namespace morphograph
