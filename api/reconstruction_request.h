#pragma once

#include <string>
#include <string_view>

#include "api/clip_request.h"
#include "synthesis/sensors/readings_reconstruction.h"

namespace morphograph {

/// The body of POST /v1/reconstructions.
struct ReconstructionBody {
  std::string model;
  ReconstructionRequest request;
  OutputFormat output;
};

/// Parses and checks `{"model", "method", "sensors": {"rate", "placements", "readings"}, "alignment": {"standing": [from, to]}, "output"}`.
/// @throws ProblemError, as ParseClipRequest().
ReconstructionBody ParseReconstructionBody(std::string_view json);

/// The first line of a stream: `{"model", "method", "placements"}`.
struct StreamHead {
  std::string model;
  ReconstructionMethod method = ReconstructionMethod::kOlng;
  std::vector<Placement> placements;
};
StreamHead ParseStreamHead(std::string_view json);

}  // namespace morphograph
