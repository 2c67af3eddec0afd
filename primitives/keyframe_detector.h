#pragma once

#include <string_view>
#include <vector>

#include "datasets/motion_clip.h"
#include "primitives/keyframe.h"

namespace morphograph {

/// What marks the moment at which a foot lands.
enum class LandingFeature {
  kReach,    // greatest reach of the foot ahead of the pelvis: walking
  kContact,  // first frame of the foot's contact: gaits with a flight, where the foot swings back before it lands
};

/// Limits are of the body and of time, not of a recording: no frame counts, no heights.
struct KeyframeOptions {
  LandingFeature landing = LandingFeature::kReach;
  double low_pass_hz = 6;          // zero phase, before features are taken; steps come at 1 to 3 Hz
  double min_step_s = 0.25;        // Du's step size: of two peaks closer than this the higher stays
  double min_prominence = 0.12;    // of a distance peak, as part of the clip's range of distance
  double min_swing_m = 0.12;       // way of a foot to its landing
  double rest_ratio = 0.25;        // a foot that landed is slower than this part of its fastest in the swing
  double landing_delay_s = 0.02;   // from the greatest reach to the touch: the foot swings back a little
  double min_seen_s = 0.12;        // a landing this close to the end of the clip cannot be told from a graze
  double standing_pelvis_m_s = 0.12;  // slower: standing
  double standing_foot_m_s = 0.25;    // both feet slower: standing or double stance
  double min_standing_s = 0.4;
  double max_standing_gap_s = 0.2;    // a shorter shift of weight does not end a standing phase
};

/// Whether KeyframeOptionsFor() knows an action.
bool HasKeyframeFeatures(std::string_view action);

/// Options for the actions that are known: "walk" and "run". @throws std::invalid_argument for any other.
KeyframeOptions KeyframeOptionsFor(std::string_view action);

/// Finds the key frames of walking by feature (Du 3.1, 4.2.1), in time order.
///
/// A landing is a peak of the distance between the ankles over the floor, found with a least step time; its side is
/// the foot that travelled further since the feet passed, and it comes to rest. Departures from Du: a peak needs prominence rather than
/// height above the mean of maximum and minimum, so that short first steps and the inner steps of a turn stay; and
/// the key frame is put, at sub-frame precision, at the landing foot's greatest reach ahead of the pelvis plus
/// `landing_delay_s`, which follows the foot strike with about half the spread of the distance peak.
/// Flat low areas of the distance (below the mean of maximum and minimum, both feet slow) are double stances, one key
/// frame at the least distance; where the pelvis stands still too, the first and last frame of the phase are marked
/// as standing instead, whatever the distance. Landings that close the feet for a stand have no peak and
/// are taken from the contacts.
/// @throws std::invalid_argument when knees, ankles or toes have no role.
std::vector<Keyframe> DetectKeyframes(const MotionClip& clip, const KeyframeOptions& options = {});

}  // namespace morphograph
