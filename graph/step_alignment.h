#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/training_steps.h"
#include "primitives/pose_layout.h"
#include "primitives/time_warp.h"

namespace morphograph {

/// The steps of a class on one timeline.
struct AlignedClass {
  int reference = 0;            // place in the class of the segment that the others are aligned to
  std::vector<int> steady;      // places in the class of its steady steps
  std::vector<TimeWarp> warps;  // of every member, from the reference's phase to its own
  Eigen::MatrixXd vectors;      // (values x members), see StepReduction
};

/// Aligns the steps of a class (Du 3.2): the reference is the steady segment with the least mean distance to the others, time taken as
/// uniform; the others are warped to it by DTW under the weighted frame distance.
/// @throws std::invalid_argument when no member is steady.
AlignedClass AlignClass(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps, const StepClass& members,
                        const PoseLayout& layout, const MeanRotations& means);

}  // namespace morphograph
