#pragma once

#include <vector>

#include "datasets/manifest.h"
#include "datasets/motion_clip.h"

namespace morphograph {

struct AugmentationOptions {
  bool mirror = false;
  /// Turns of the path per step with which every clip is bent, radians; empty: none.
  std::vector<double> bends_rad;
  double bend_ease_s = 0.6;
};

/// What a manifest's `mirror` and `bend` stand for: bends by 7, 14 and 20 degrees a step to either side.
AugmentationOptions AugmentationOf(const DatasetManifest& manifest);

struct AugmentedClip {
  MotionClip clip;
  bool made = false;  // a copy
};

/// The clips, each on a level floor and followed by its made copies: its end as a stop where it holds a pose (eased_stop.h), mirrored, then
/// all of these bent.
///
/// Clips whose skeleton has no leg roles pass unchanged. A clip that stands or turns by itself is bent like any other. Done on up to
/// `jobs` threads; the order and the result do not depend on them.
/// @throws DatasetError naming a clip that cannot be copied.
std::vector<AugmentedClip> Augment(const std::vector<MotionClip>& clips, const AugmentationOptions& options, int jobs = 1);

}  // namespace morphograph
