#pragma once

#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// Everything `evaluate` says of one clip.
struct ClipEvaluation {
  ClipQuality quality;
  std::vector<PlantedFoot> contacts;  // in the clip's own frames
  // Curves at 30 fps (kEvaluationRateHz), the clip's own frames when that is its rate.
  std::vector<double> contact_distance_m;  // a value a frame (Du Fig. 4.17); 0 where no foot is planted
  std::vector<double> frame_difference;    // D(F_i, F_i+1), frames - 1 values (Du Fig. 4.18)
};

/// Evaluates any clip with leg roles, synthesised or captured, by the same measures (METHODS section 6): the
/// ground and the contacts are found from the clip itself.
/// @throws std::invalid_argument when leg roles are missing, there are fewer than 2 frames, or a joint is not
/// finite.
ClipEvaluation EvaluateClip(const MotionClip& clip);

/// The same for a clip at 30 fps whose joint positions and contacts are known already, so that nothing is
/// worked out twice. To compare fairly, `motion.contacts` must come from DetectContacts, not from the labels
/// of a model.
ClipEvaluation EvaluateMotion(const EvaluationMotion& motion);

/// Where each planted foot stood. Intervals must lie within the track's frames.
std::vector<PlantedFoot> PlantedFeet(const ContactTrack& contacts);

/// How a set of clips compares with a reference set (METHODS section 6).
struct SetComparison {
  double frechet = 0;         // set against reference
  double frechet_halves = 0;  // reference against itself: mean over random halves
  double frechet_ratio = 0;   // frechet / frechet_halves
  /// Mean squared distance of a window from the reference's 32 leading directions, set / reference. The
  /// Fréchet distance is blind to what leaves those directions (a pose that the reference never varies,
  /// noise); this is not.
  double residual_ratio = 0;
  double diversity = 0;  // mean pairwise window distance inside the set
  double diversity_reference = 0;
  int windows = 0;
  int windows_reference = 0;
};

/// Fréchet distance and diversity in the WindowSpace of the reference; halves are halves of its clips, drawn
/// 20 times.
/// @throws std::invalid_argument when either set yields fewer than 64 windows, the reference fewer than four
/// clips with any, or evaluation roles are missing.
SetComparison CompareSets(const std::vector<MotionClip>& clips, const std::vector<MotionClip>& reference,
                          std::uint64_t seed = 1);
/// The same on pose windows (synthesis/pose_windows.h), a matrix a clip, for those who compare one set many
/// times.
SetComparison CompareWindowSets(const std::vector<Eigen::MatrixXd>& clips,
                                const std::vector<Eigen::MatrixXd>& reference, std::uint64_t seed = 1);

}  // namespace morphograph
