#pragma once

#include <vector>

#include "datasets/retarget.h"
#include "synthesis/sensors/motion_base.h"
#include "tests/synthesis/gait_clips.h"

namespace morphograph::testing {

/// Made walks on one skeleton.
inline std::vector<MotionClip> WalksOnOneSkeleton(int count) {
  std::vector<MotionClip> clips = GaitClips(1, count, [](SyntheticGaitOptions&) {});
  for (MotionClip& clip : clips) clip = Retarget(clip, clips.front().shared_skeleton());
  return clips;
}

/// A base of five made walks with sensors at wrists and ankles.
inline const MotionBase& SmallBase() {
  static const MotionBase base(WalksOnOneSkeleton(5), PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"}), {});
  return base;
}

/// A walk that SmallBase() has not, on its skeleton.
inline MotionClip UnseenWalk() {
  return Retarget(GaitClip(99, [](SyntheticGaitOptions& options) { options.speed_m_s = 1.22; }), SmallBase().shared_skeleton());
}

}  // namespace morphograph::testing
