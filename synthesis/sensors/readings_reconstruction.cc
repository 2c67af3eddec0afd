#include "synthesis/sensors/readings_reconstruction.h"

#include <algorithm>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/errors.h"

namespace morphograph {

ReconstructedReadings ReconstructReadings(const MotionGraph& graph, const ReconstructionRequest& request, const ReconstructorSource& make) {
  // What cannot be placed is said before any work is done.
  PlacesOf(request.readings.names, request.placements, graph, request.method);
  StreamRepairOptions options;
  options.kind = request.method == ReconstructionMethod::kMarkers ? ReadingsKind::kMarkers : ReadingsKind::kAccelerations;
  options.rate_hz = kReconstructionRate_hz;
  ReconstructedReadings result;
  result.repaired = RepairStream(request.readings, options, request.source);
  const Readings& readings = result.repaired.readings;
  const std::vector<int>& dead = result.repaired.dead_sensors;
  std::vector<Eigen::Index> rows;
  for (int s = 0; s < readings.sensor_count(); ++s) {
    if (std::binary_search(dead.begin(), dead.end(), s)) continue;
    result.sensors.push_back(readings.names[static_cast<std::size_t>(s)]);
    for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * static_cast<Eigen::Index>(s) + axis);
  }
  const std::shared_ptr<const Reconstructor> reconstructor = make(PlacesOf(result.sensors, request.placements, graph, request.method));
  try {
    result.reconstruction = reconstructor->Run(readings.values(rows, Eigen::all));
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(request.source, ReasonOf(unfit));
  }
  return result;
}

}  // namespace morphograph
