#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/motion_graph.h"
#include "synthesis/sensors/captured_steps.h"
#include "synthesis/sensors/step_fit.h"
#include "synthesis/sensors/step_search.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// A walk over the graph that readings of sensors make likely, and how well it explains them.
struct GraphReconstruction {
  SynthesisResult result;       // clip at kSensorRate_hz, a frame a reading, from the origin facing +Z; report with steps and their likelihood
  double residual_m_s2 = 0;     // root mean square of readings less the steps'
};

/// The graph method (METHODS section 5): readings are cut into steps (StepSearch), each step is the most likely one given its readings (FitStep), and the steps are
/// joined, their feet locked, as those of any walk over the graph. The style is the one most of the nearest captured steps have; it says where feet stand. The
/// likelihood of a step is that of its projection on the graph's primitive, after the one before it.
/// @param readings  (3 * sensors x frames) at kSensorRate_hz, finite, of `steps`' sensors.
/// @throws std::invalid_argument where the readings are too short for a step, or not as many as the sensors; UnsatisfiableRequest where no style of
///   the graph walks.
GraphReconstruction ReconstructWalk(const MotionGraph& graph, const CapturedSteps& steps, const StepSearch& search, const Eigen::MatrixXd& readings,
                                    const StepFitOptions& options = {});

}  // namespace morphograph
