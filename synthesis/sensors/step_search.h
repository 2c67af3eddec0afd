#pragma once

#include <Eigen/Core>
#include <vector>

#include "synthesis/sensors/captured_steps.h"

namespace morphograph {

/// A step that was found in a stream of readings; frames of the stream at kSensorRate_hz, beyond its ends where it begins before or ends after it.
struct FoundStep {
  double start_frame = 0;
  double end_frame = 0;
  bool left = false;  // the foot that lands at its end

  double frames() const { return end_frame - start_frame; }
};

/// Cuts readings into steps: the sequence of alternate left and right steps, whole frames long, under which the readings are nearest to those of captured
/// steps (METHODS section 5, the search of the graph method). Found by dynamic programming over all places of key frames, so no sequence is nearer.
///
/// The cost of a step is the mean squared distance of its readings, margins included, from those of the few nearest captured steps of that side, times its
/// length; distances are taken in the banks' leading principal components, what leaves these is added. What lies before the first and behind the last
/// whole step costs what a frame of the stream costs in the middle, and is then given the step that fits best what there is of it.
class StepSearch {
 public:
  /// @param steps  must outlive the search.
  explicit StepSearch(const CapturedSteps& steps);

  /// @param readings  (3 * sensors x frames) at kSensorRate_hz, finite.
  /// @return steps that cover all frames, in order. Empty where there are fewer frames than in the shortest captured step.
  std::vector<FoundStep> Find(const Eigen::MatrixXd& readings) const;

 private:
  struct Side {
    Eigen::VectorXf mean;      // of the bank's readings and weighted log durations
    Eigen::MatrixXf basis;     // (values x components)
    Eigen::MatrixXf captured;  // (components x steps), by rising duration
    std::vector<float> log_durations;  // of its columns, s
    Eigen::VectorXf norms;     // of its columns, squared
  };
  /// Mean squared distance of steps that start at `start` and last `frames` (several), by side.
  Eigen::MatrixXf CostsAt(const Eigen::MatrixXd& readings, int start) const;  // (lengths x 2)
  FoundStep PartialStep(const Eigen::MatrixXd& readings, double key_frame, double neighbour_frames, bool left, bool leading) const;

  const CapturedSteps& steps_;
  Side sides_[2];
  int shortest_ = 0, longest_ = 0;  // frames
};

}  // namespace morphograph
