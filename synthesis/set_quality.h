#pragma once

#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// Measures of a set of clips that need no reference. Ratios of two sets of these are what the published
/// tables give.
struct SetQuality {
  int clips = 0;
  int pieces = 0;      // that were measured
  double seconds = 0;  // in all of them
  // Means over pieces; contact distance over planted foot-frames.
  double contact_distance_m = 0;
  double foot_skate_cm_s = 0;
  double planted_skate_cm_s = 0;  // the part of planted balls
  double naturalness = 0;  // m^4
  // Over all frames and evaluation joints.
  double acceleration_p999_m_s2 = 0;
  double mean_jerk_m_s3 = 0;
  // Worst of all frames.
  double penetration_m = 0;
  double min_knee_flexion_deg = 0;
  double max_knee_flexion_deg = 0;
  double lowest_m = 0;  // of heels, balls and ankles above the contact plane
  double bone_length_error_m = 0;
};

struct SetQualityOptions {
  /// Clips are cut into pieces of this many frames at 30 fps and the rest is left out, so that sets of short
  /// and of long clips compare: a plane fits few stances better than many, and a long clip varies more. 0
  /// measures whole clips.
  int piece_frames = 90;
};

/// @throws std::invalid_argument when no clip holds a piece, leg roles are missing, or a clip is not finite.
SetQuality MeasureSet(const std::vector<MotionClip>& clips, const SetQualityOptions& options = {});

}  // namespace morphograph
