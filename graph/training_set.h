#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "graph/graph_builder.h"
#include "graph/training_steps.h"
#include "primitives/pose_layout.h"

namespace morphograph {

class TrainingProgress;

/// Clips cut into steps and sorted into classes: what models are learned from, and what studies of one stage start with.
struct TrainingSet {
  std::vector<PreparedClip> clips;  // usable ones, on the skeleton of the first
  std::vector<TrainingStep> steps;
  std::vector<StepClass> classes;   // with enough steady steps, sorted by action (the usual one first), style and name
  PoseLayout layout;
  std::vector<GraphStyle> styles;   // of the classes, sorted by action and name
  Eigen::VectorXd channel_weights;  // PoseLayout::ChannelWeights; one set for all, so that classes compare
  std::vector<std::string> notes;   // what had to be left out
};

/// The style of a class. @throws std::out_of_range when the set has no such style.
const GraphStyle& StyleOf(const TrainingSet& set, const StepClass& members);

/// The part of BuildGraph that comes before any model is fitted; throws what that throws.
/// @param progress  if given, hears of the stages "clips" and "steps", a quarter of the whole.
TrainingSet PrepareTrainingSet(const std::vector<TrainingClip>& clips, const TrainingOptions& options,
                               TrainingProgress* progress = nullptr);

}  // namespace morphograph
