#pragma once

#include <map>
#include <optional>
#include <random>
#include <vector>

#include "graph/motion_graph.h"
#include "synthesis/graph_walk.h"

namespace morphograph {

/// What comes after a step of a walk that is to change its action.
struct ChangeTry {
  WalkStep step;  // the made step, or, where none is near enough, the step of the old action that came nearest to the new one
  std::optional<StepWithContacts> made;
};

/// Draws the made steps of one walk (see ActionChange).
class ActionChanger {
 public:
  ActionChanger(const MotionGraph& graph, std::mt19937_64& rng) : graph_(graph), rng_(rng) {}

  /// Draws a few next steps of the old action and holds them against steps of the new one, which are drawn once. The pair that is nearest
  /// (ChangeDistance_m) is made one, if that takes no more than captured steps do.
  /// @param style  entry of the new action among the graph's styles.
  /// @return empty where no change begins after that step: it is the other foot's turn.
  std::optional<ChangeTry> Try(const WalkStep& previous, int style);

 private:
  struct Candidate {
    WalkStep step;
    StepShape shape;
  };
  const std::vector<Candidate>& CandidatesOf(int primitive);

  const MotionGraph& graph_;
  std::mt19937_64& rng_;
  std::map<int, std::vector<Candidate>> candidates_;  // by primitive
};

}  // namespace morphograph
