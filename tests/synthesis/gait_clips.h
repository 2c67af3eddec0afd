#pragma once

#include <cstdint>
#include <vector>

#include "datasets/synthetic_gait.h"

namespace morphograph::testing {

/// A made walk of about 8 s at 30 fps that neither starts nor stops; `change` alters its options.
template <typename Change>
MotionClip GaitClip(std::uint64_t seed, Change change) {
  SyntheticGaitOptions options;
  options.seed = seed;
  options.frame_rate_hz = 30;
  options.steps = 16;
  options.start_standing = options.stop_standing = false;
  change(options);
  return GenerateGait(options);
}
inline MotionClip GaitClip(std::uint64_t seed) {
  return GaitClip(seed, [](SyntheticGaitOptions&) {});
}

/// `count` walks of different seeds, speeds and headings.
template <typename Change>
std::vector<MotionClip> GaitClips(std::uint64_t seed, int count, Change change) {
  std::vector<MotionClip> clips;
  for (int i = 0; i < count; ++i) {
    clips.push_back(GaitClip(seed + static_cast<std::uint64_t>(i), [&](SyntheticGaitOptions& options) {
      options.speed_m_s = 1.1 + 0.05 * (i % 5);
      options.heading_rad = 0.7 * i;
      change(options);
    }));
  }
  return clips;
}

}  // namespace morphograph::testing
