#pragma once

#include <optional>
#include <string>

#include "synthesis/sensors/readings_reconstruction.h"

namespace morphograph {

/// The clip's report (ReportJson) with a member "reconstruction": method, sensors used, what was lost and done about it, how well the walk explains the readings,
/// latency, and, where the true motion is known, errors against it.
std::string ReconstructionReportJson(ReconstructionMethod method, const ReconstructedReadings& made, const std::optional<ReconstructionQuality>& errors = {});

}  // namespace morphograph
