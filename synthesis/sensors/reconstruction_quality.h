#pragma once

#include <vector>

#include "datasets/motion_clip.h"
#include "synthesis/sensors/motion_base.h"

namespace morphograph {

/// How near a reconstructed motion comes to the true one, frame by frame and over all. Joints are seen in the pelvis frame (moving root at the origin, its axes), so
/// that where and how the body stands in the world does not count.
struct ReconstructionQuality {
  int frames = 0;
  double position_rms_cm = 0;          // mean over frames of the root mean square distance of the measured joints
  double position_rms_p95_cm = 0;      // the same, 95th percentile over frames
  double angle_deg = 0;                // mean angle between local rotations, over active joints and frames
  double normalised_rms = 0;           // Xie Eq. 7.1: ||joint angles - true|| / ||true||, of rotation vectors about the base's means
  double velocity_error_cm_s = 0;      // root mean square over joints and frames of the difference of velocities, pelvis frame
  double jerk_ratio = 0;               // root mean square third difference of joint positions in the pelvis frame / the truth's
  double contact_agreement = 0;        // share of foot-frames that agree on standing or not, of both clips with their own motion
  std::vector<double> frame_rms_cm;    // a value a frame
};

/// Compares poses with the truth. Both are of the base's channels and rate, equally many, and 4 or more.
/// @param truth  the true clip on the base's skeleton and at its rate, for contacts; they are left at 0 where the skeleton has no leg roles.
/// @throws std::invalid_argument for different lengths or too few frames.
ReconstructionQuality CompareWithTruth(const MotionBase& base, const std::vector<BasePose>& poses, const MotionClip& truth);

/// The truth in the base's channels. @param clip  on a skeleton of the base's joints; resampled to the base's rate.
std::vector<BasePose> PosesOf(const MotionBase& base, const MotionClip& clip);

}  // namespace morphograph
