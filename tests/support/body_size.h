#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph::testing {

/// The same motion of a body whose lengths are all this many times as long.
inline MotionClip OfSize(const MotionClip& clip, double scale) {
  std::vector<Joint> joints = clip.skeleton().joints();
  for (Joint& joint : joints) {
    joint.offset_m *= scale;
    if (joint.end_site_m) *joint.end_site_m *= scale;
  }
  const auto skeleton = std::make_shared<const Skeleton>(std::move(joints), clip.skeleton().roles(), clip.skeleton().metres_per_unit(), clip.skeleton().up_axis());
  MotionClip scaled(skeleton, clip.frame_rate_hz(), clip.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) std::copy_n(clip.rotations(f), clip.joint_count(), &scaled.rotation(f, 0));
  scaled.root_positions() = scale * clip.root_positions();
  scaled.name = clip.name;
  scaled.style = clip.style;
  return scaled;
}

}  // namespace morphograph::testing
