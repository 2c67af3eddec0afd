#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "graph/motion_graph.h"
#include "synthesis/sensors/sensor_steps.h"
#include "synthesis/sensors/step_fit.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {

/// Steps that readings of sensors make likely, put on the graph: each with the primitive it is of, its projection on that primitive's latents, and its likelihood
/// after the step before it. Times in frames at kSensorRate_hz, the readings' first at 0; the first step may begin before it.
struct FoundWalk {
  int style = 0;  // of the graph's styles
  std::vector<DrawnStep> steps;
  double residual_m_s2 = 0;  // root mean square of readings less the steps'
};

/// In which style to look for a walk: of the graph's styles, or where that is not given, the one of an action that most of the nearest captured steps have.
struct StyleChoice {
  std::optional<int> style = {};
  std::string action = {};  // empty: the graph's own
};

/// Cuts readings into steps (StepSearch) and makes each the most likely one given its readings (FitStep).
/// @param readings  (3 * sensors x frames) at kSensorRate_hz, finite, of `sensors`.
/// @return no steps where the readings are shorter than one.
/// @throws std::invalid_argument for readings of other sensors; UnsatisfiableRequest where no such style walks.
FoundWalk FindWalk(const MotionGraph& graph, const SensorSteps& sensors, const Eigen::MatrixXd& readings, const StyleChoice& style = {},
                   const StepFitOptions& options = {});

}  // namespace morphograph
