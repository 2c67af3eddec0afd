#include "synthesis/sensors/graph_reconstruction.h"

#include <stdexcept>

#include "synthesis/walk_clip.h"
#include "synthesis/walk_report.h"

namespace morphograph {

GraphReconstruction ReconstructWalk(const MotionGraph& graph, const SensorSteps& sensors, const Eigen::MatrixXd& readings, const StepFitOptions& options) {
  FoundWalk found = FindWalk(graph, sensors, readings, {}, options);
  if (found.steps.empty()) throw std::invalid_argument("ReconstructWalk: the readings are shorter than a step");
  const DrawnWalk walk{std::move(found.steps), static_cast<int>(readings.cols())};
  GraphReconstruction reconstruction;
  reconstruction.residual_m_s2 = found.residual_m_s2;
  reconstruction.result.clip = MakeWalkClip(graph, walk.steps, walk.frames, kSensorRate_hz, {});
  reconstruction.result.report = DescribeWalk(graph, walk, reconstruction.result.clip);
  return reconstruction;
}

}  // namespace morphograph
