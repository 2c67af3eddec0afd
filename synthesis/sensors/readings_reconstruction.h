#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datasets/stream_repair.h"
#include "synthesis/sensors/reconstruction.h"

namespace morphograph {

/// Readings as they come, damage included, and what is known of their sensors.
struct ReconstructionRequest {
  ReconstructionMethod method = ReconstructionMethod::kGraph;
  Readings readings;
  std::vector<Placement> placements;   // by name; sensors without one sit at the joint that they are called after
  std::string source = "readings";     // the file, for messages
};

/// The reconstruction and what was wrong with the readings.
struct ReconstructedReadings {
  Reconstruction reconstruction;
  RepairedReadings repaired;
  std::vector<std::string> sensors;    // that were used
};

/// Gives the reconstructor for sensors at some places; one that was made before may do.
using ReconstructorSource = std::function<std::shared_ptr<const Reconstructor>(const std::vector<Placement>&)>;

/// Repairs readings, leaves dead sensors out, and reconstructs.
/// @throws DatasetError for readings that nothing can be made of, or that look like markers where accelerations are wanted or the other way round; UnsatisfiableRequest for sensors that cannot be placed or a stream shorter than a step.
ReconstructedReadings ReconstructReadings(const MotionGraph& graph, const ReconstructionRequest& request, const ReconstructorSource& make);

}  // namespace morphograph
