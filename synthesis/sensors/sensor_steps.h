#pragma once

#include <vector>

#include "graph/motion_graph.h"
#include "synthesis/sensors/captured_steps.h"
#include "synthesis/sensors/step_search.h"

namespace morphograph {

/// Captured steps, and copies of them that are a little slower and faster, with the readings of sensors at some places, and their search. Steps at a tempo that the recordings lack
/// read otherwise by its square, and would find no like. Made from the recordings that a model keeps; where it keeps none, from walks
/// that it makes itself. That takes seconds and some hundred megabytes: keep it for the next readings of the same sensors. Immutable.
class SensorSteps {
 public:
  SensorSteps(const std::vector<MotionClip>& clips, const std::vector<RecordedStep>& recorded, const PoseLayout& layout, std::vector<Placement> sensors, int jobs = 1)
      : steps_(clips, recorded, layout, std::move(sensors), true, jobs, {0.85, 1.15}), search_(steps_) {}
  SensorSteps(const SensorSteps&) = delete;
  SensorSteps& operator=(const SensorSteps&) = delete;

  const CapturedSteps& steps() const { return steps_; }
  const StepSearch& search() const { return search_; }

 private:
  CapturedSteps steps_;
  StepSearch search_;
};

}  // namespace morphograph
