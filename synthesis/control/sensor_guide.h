#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "datasets/stream_repair.h"
#include "synthesis/sensors/found_walk.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// Readings that steer a clip, made ready: repaired, and cut into the steps that they make likely. Immutable; clips of one request share it.
struct SensorGuide {
  std::vector<Placement> placements;  // of the sensors that are alive
  RepairedReadings repaired;
  Eigen::MatrixXd readings;  // (3 * placements x frames) at kSensorRate_hz, m/s^2; the first at the clip's start
  FoundWalk walk;            // no steps where the readings are shorter than one

  /// About how much memory it takes.
  std::size_t bytes() const;
  double duration_s() const { return static_cast<double>(readings.cols() - 1) / kSensorRate_hz; }
};

/// Gives the captured steps for sensors at some places; some that were made before may do.
using SensorStepsSource = std::function<std::shared_ptr<const SensorSteps>(const std::vector<Placement>&)>;

/// Makes a request's readings ready. Fewer than 3 samples, which say nothing of a motion, steer nothing; that is told in `repaired.notes`.
/// @param request  with control terms that have readings. @param source  makes them anew where it is empty.
/// @throws UnsatisfiableRequest for readings that nothing can be made of ("/sensors/readings"), sensors that cannot be placed, what cannot be asked for together
///   with readings, and models whose recordings hold no step ("/model"); std::invalid_argument for a request that is not well formed.
std::shared_ptr<const SensorGuide> MakeSensorGuide(const MotionGraph& graph, const SynthesisRequest& request, const SensorStepsSource& source = {});

/// Gives the request its guide, where it has readings and none yet.
void PrepareSensors(const MotionGraph& graph, SynthesisRequest* request, const SensorStepsSource& source = {});

}  // namespace morphograph
