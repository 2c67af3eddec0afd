#pragma once

#include <random>
#include <vector>

#include "synthesis/control/kinematics_cache.h"
#include "synthesis/control/steer_budget.h"
#include "synthesis/control/walk_guide.h"

namespace morphograph {

/// A legal walk over the graph, set down on the floor.
struct WalkPlan {
  std::vector<WalkStep> steps;
  std::vector<KeyframePlace> places;  // one more than steps: where each begins, and where the last ends
  std::vector<double> along_m;        // the same, on the guide's path
  int frames = 0;                     // of the clip; where the walk stops, its last step's margin is the end
  int first_contacts[2] = {0, 0};     // planted intervals of left and right foot that are taken to have begun before the first step ends
};

/// Finds a walk near to what is asked: a beam search over the graph whose successors are drawn from the transitions, so that every walk it
/// finds is one that might have been drawn (METHODS section 4). What is still missing is the optimiser's work.
/// @param effort  1 or more: how many times the usual number of walks are followed.
/// @param budget  what the search takes is taken from it; once it is spent, the best of the walks that are over by then is the one found.
/// @throws UnsatisfiableRequest where no walk begins, goes on or ends as asked, or none that the budget allows for.
WalkPlan PlanWalk(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, SteerBudget* budget, std::mt19937_64& rng);

}  // namespace morphograph
