#pragma once

#include <cstdint>

#include "datasets/motion_clip.h"

namespace morphograph {

/// What a low-cost markerless capture does to a clip. Rates are per second and joint; 0 turns a kind of noise off.
struct NoiseOptions {
  double leaf_jitter_rad = 0.08;    // standard deviation of white noise on the rotation of leaf joints and their parents
  double root_jitter_m = 0.008;     // on each coordinate of the root's position
  double root_jitter_rad = 0.02;    // on the root's rotation
  double slips_per_s = 0.2;         // a limb (or the root) is lost and drifts off, then comes back
  double slip_rad = 0.35;           // standard deviation of the greatest turn of a slip
  double slip_m = 0.05;             // of the root's greatest shift
  double slip_s = 0.3;              // mean length
  double dropouts_per_s = 0.15;     // a limb (or the root) freezes while the body moves on, then jumps back
  double dropout_s = 0.12;          // mean length
};

/// The clip with jitter, slips and dropouts on its leaf joints (those that carry the ends of limbs: ankles, toes, wrists, hands, head) and its
/// moving root. Bone lengths stay. The same clip, options and seed give the same noise, whatever other clips there are.
/// @throws std::invalid_argument naming an option that is negative or not finite.
MotionClip AddNoise(const MotionClip& clip, const NoiseOptions& options, std::uint64_t seed);

}  // namespace morphograph
