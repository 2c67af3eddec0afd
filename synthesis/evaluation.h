#pragma once

#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// Everything `evaluate` says of one clip.
struct ClipEvaluation {
  ClipQuality quality;
  std::vector<PlantedFoot> contacts;
  std::vector<double> contact_distance_m;  // a value a frame (Du Fig. 4.17); 0 where no foot is planted
  std::vector<double> frame_difference;    // D(F_i, F_i+1), frames - 1 values (Du Fig. 4.19)
};

/// Evaluates any clip with leg roles, synthesised or captured, by the same measures (METHODS section 6): the ground and the
/// contacts are found from the clip itself.
/// @throws std::invalid_argument when leg roles are missing or there are fewer than 2 frames.
ClipEvaluation EvaluateClip(const MotionClip& clip);

/// How a set of clips compares with a reference set (METHODS section 6).
struct SetComparison {
  double frechet = 0;            // set against reference
  double frechet_halves = 0;     // reference against itself: mean over random halves
  double frechet_ratio = 0;      // frechet / frechet_halves
  double diversity = 0;          // mean pairwise window distance inside the set
  double diversity_reference = 0;
  int windows = 0;
  int windows_reference = 0;
};

/// @throws std::invalid_argument when either set yields fewer than 64 windows, or evaluation roles are missing.
SetComparison CompareSets(const std::vector<MotionClip>& clips, const std::vector<MotionClip>& reference,
                          std::uint64_t seed = 1);

}  // namespace morphograph
