#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/training_set.h"
#include "graph/transition_model.h"

namespace morphograph {

/// Steps of one class that follow steps of another in the capture: what a transition is learned from.
struct StepPairs {
  int from = 0, to = 0;               // classes of the set
  std::vector<int> previous, next;    // per pair: places in these classes
  std::vector<int> source;            // per pair: the captured clip, see TransitionPairs::clip
  std::vector<char> made;

  int size() const { return static_cast<int>(previous.size()); }
};

/// All pairs of a set, sorted by `from` and `to`, each list in the order of the clips. Among walking steps only steady ones make pairs: those
/// that still gather speed follow starts, and lead into ends.
std::vector<StepPairs> FindStepPairs(const TrainingSet& set);

/// Their latents. @param from, to  (components x members) of the two classes.
TransitionPairs LatentsOf(const StepPairs& pairs, const Eigen::MatrixXd& from, const Eigen::MatrixXd& to);

}  // namespace morphograph
