#pragma once

#include "synthesis/control/kinematics_cache.h"
#include "synthesis/control/planned_step.h"
#include "synthesis/control/steer_budget.h"
#include "synthesis/control/walk_guide.h"

namespace morphograph {

/// How far the steps of a walk are from what a guide asks: squares of what they miss, in the deviations that the optimiser can still make good.
class GuideCost {
 public:
  /// All arguments must outlive it. @param budget  what each step that is looked at takes is taken from it.
  GuideCost(const MotionGraph& graph, const WalkGuide& guide, KinematicsCache* kinematics, SteerBudget* budget)
      : graph_(graph), guide_(guide), kinematics_(*kinematics), budget_(*budget) {}

  /// Sets the last step down, from its place on: where it ends, and what it costs.
  void SetDown(PlannedStep* last) const;
  /// Bends a drawn step towards what is asked: the most likely change of its latent, were its prior N(0, I) about what was drawn and the terms
  /// known to within the search's deviations. Turns are rare among draws, and a path that asks for one should not have to wait for it.
  void Bend(PlannedStep* step) const;
  /// What is missing of the goal in a walk that is over at a time of its last step; walks that stop do so at that step's end.
  double AtEnd(const PlannedStep& last, double end_s) const;

 private:
  void TakeWork() const;

  const MotionGraph& graph_;
  const WalkGuide& guide_;
  KinematicsCache& kinematics_;
  SteerBudget& budget_;
};

}  // namespace morphograph
