#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/training_steps.h"
#include "graph/training_variant.h"
#include "primitives/motion_primitive.h"
#include "primitives/step_vector.h"

namespace morphograph {

struct PrimitiveFitOptions {
  double variance_kept = 0.99;
  int largest_mixture = 4;
  std::uint64_t seed = 1;
  TrainingVariant variant = {};
};

/// A primitive and what its training steps became.
struct FittedPrimitive {
  MotionPrimitive primitive;
  Eigen::MatrixXd latents;  // (components x members), in the order of the class
  Eigen::MatrixXd manners;  // (components x members) manner of each step's walk; empty where the primitive has none
};

/// Fits one primitive to the steps of a class (Du 3.2-3.4): reference segment, DTW against it, weighted PCA, mixture by BIC (of one
/// component at least for 35 captured steps, four at most), contacts. Steps that are not steady shape nothing; they are projected so that transitions can use them.
FittedPrimitive FitPrimitive(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps, const StepClass& members,
                             const PoseLayout& layout, const MeanRotations& means, const Eigen::VectorXd& channel_weights,
                             const PrimitiveFitOptions& options);

}  // namespace morphograph
