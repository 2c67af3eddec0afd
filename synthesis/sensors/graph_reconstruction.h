#pragma once

#include <Eigen/Core>

#include "graph/motion_graph.h"
#include "synthesis/sensors/found_walk.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// A walk over the graph that readings of sensors make likely, and how well it explains them.
struct GraphReconstruction {
  SynthesisResult result;       // clip at kSensorRate_hz, a frame a reading, from the origin facing +Z; report with steps and their likelihood
  double residual_m_s2 = 0;     // root mean square of readings less the steps'
};

/// The graph method (METHODS section 5): the steps that readings make likely (FindWalk) are joined, their feet locked, as those of any walk over the graph.
/// @param readings  (3 * sensors x frames) at kSensorRate_hz, finite, of `sensors`.
/// @throws std::invalid_argument where the readings are too short for a step, or not as many as the sensors; UnsatisfiableRequest where no style of
///   the graph walks.
GraphReconstruction ReconstructWalk(const MotionGraph& graph, const SensorSteps& sensors, const Eigen::MatrixXd& readings, const StepFitOptions& options = {});

}  // namespace morphograph
