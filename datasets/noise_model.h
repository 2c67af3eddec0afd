#pragma once

#include <cstdint>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// What a low-cost markerless capture does to a clip. Rates are per second, for each limb and the root; 0 turns a kind of noise off.
///
/// The defaults were set beside camera-based points of a real markerless system (60 Hz, raw): their jitter is nearly white, 3 to 8 mm on a
/// coordinate in the middle and 4 to 13 mm root mean square, for in bursts they are off by 40 to 130 mm. A shank of 0.4 m that turns by
/// 0.08 rad takes the ankle 32 mm aside, a forearm the wrist 20 mm: three times that system's jitter, "heavily noisy" as Du's captures. Of
/// the steps of clean walks, some six in seven are still found to be sound.
struct NoiseOptions {
  double leaf_jitter_rad = 0.08;    // standard deviation of white noise about each axis of the joints of a limb's end
  double root_jitter_m = 0.008;     // on each coordinate of the root's position
  double root_jitter_rad = 0.02;    // about each axis of the root's rotation
  double slips_per_s = 0.2;         // a limb (or the root) is lost and drifts off, then comes back
  double slip_rad = 0.35;           // standard deviation of the greatest turn of a limb's slip
  double slip_m = 0.05;             // of the root's greatest shift
  double slip_s = 0.3;              // mean length; lengths are uniform in 0.5 to 1.5 times that
  double dropouts_per_s = 0.15;     // a limb (or the root) freezes while the body moves on, then jumps back
  double dropout_s = 0.12;          // mean length, drawn likewise
  double camera_hz = 60;            // jitter is white up to half of this; clips of a higher rate get it interpolated
};

/// The ends of the limbs: for the head, each wrist and each ankle, the joint that moves it (neck, elbow, knee), itself and all below
/// it, that joint first. Where a skeleton has none of these roles: each leaf joint with its parent. Joints above the moving root and the
/// root itself are never among them.
std::vector<std::vector<int>> NoisyLimbs(const Skeleton& skeleton);

/// The clip with jitter, slips and dropouts on its NoisyLimbs and its moving root. Bone lengths and all other joints stay. The same clip
/// (by name), options and seed give the same noise, whatever other clips there are; a kind of noise that is turned off changes none of
/// the others.
/// @throws std::invalid_argument naming an option that is negative or not finite, or a length or camera rate that is not positive.
MotionClip AddNoise(const MotionClip& clip, const NoiseOptions& options, std::uint64_t seed);

}  // namespace morphograph
