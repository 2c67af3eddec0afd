#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "synthesis/control/steer_budget.h"
#include "synthesis/control/walk_state.h"

namespace morphograph {

/// What a walk that readings steer is drawn with: noise in place of the innovations and the reading errors, so that the optimum is a draw from what readings leave
/// possible (randomised maximum likelihood, as InnovationResidual). The most likely walk itself would be the same for every seed.
struct PosteriorDraw {
  std::vector<Eigen::VectorXd> innovations;  // of the steps that were found in the readings, the first one's latent within its walk in place of an innovation
  Eigen::MatrixXd readings_m_s2;             // of the readings' size
};
PosteriorDraw DrawPosterior(const SensorGuide& sensors, std::mt19937_64& rng);

/// Moves a planned walk to where it meets its terms, and no farther from the plan than that takes: maximum a posteriori over the whitened
/// latents of all steps at once (METHODS section 4), by Ceres. Innovations stay near the drawn ones, so that results keep the variety
/// of the model (see InnovationResidual).
///
/// Clips are made of cross-faded steps with their feet locked, so that they deviate from what the steps alone say. The clip is therefore
/// made after each solution, what it really does is measured, and the difference becomes part of the next one, until the terms are met
/// on the clip itself or no longer come nearer.
/// A step whose swing comes out faster or higher than swings of its kind do is held to their range in the solutions after that (SwingResidual).
/// @param budget  what it takes is taken from it; once it is spent, the round that is under way is the last.
/// @param draw  of a problem with readings.
SteeredWalk OptimizeWalk(const ControlProblem& problem, const WalkPlan& plan, KinematicsCache* kinematics, SteerBudget* budget, const PosteriorDraw& draw = {});

}  // namespace morphograph
