#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/placements.h"

namespace morphograph {

/// What sensors at some places read on a body that stands: what sensors that somebody wears are aligned by.
struct WornSensors {
  Eigen::Matrix3Xd up;    // (3 x sensors): unit, the way up in the axes of each
  Eigen::VectorXd spread_rad;  // (sensors): root mean square angle between that and the frames it is the mean of, 3 degrees at least
  bool standing = false;  // from standing that the clips show; else a guess, some degrees off
};

/// Of clips in which somebody stands for a second in all (pelvis and feet at rest), the mean over those frames. Of clips that only walk: of legs, the mean over the frames in which their foot lies flat
/// on the floor; of trunk and arms, over all frames. Some thousand frames are looked at, evenly taken.
/// @throws std::invalid_argument for no clips, or a joint that the skeleton does not have.
WornSensors WornBy(const std::vector<MotionClip>& clips, const std::vector<Placement>& placements);

}  // namespace morphograph
