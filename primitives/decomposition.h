#pragma once

#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "primitives/keyframe.h"

namespace morphograph {

/// A piece of a clip between two key frames; frames are sub-frame positions in the clip.
struct Segment {
  int clip = 0;
  double start_frame = 0;
  double end_frame = 0;
  KeyframeLabel start = KeyframeLabel::kRightStance;
  KeyframeLabel end = KeyframeLabel::kLeftStance;
  std::string primitive;  // class: "left_walk", "right_first_start", "left_end", …
  int previous = -1;      // index of the segment that ends where this one starts, in the list returned; -1 if none
  bool steady = true;     // a regular sample of its class; false while speed builds up or dies down, or implausible
  bool slow_step = false;  // a start (an end) that is a slow first (last) step of the clip, not bounded by standing
};

struct DecompositionOptions {
  std::string action = "walk";  // steps are named "<side>_<action>"; other than walk they may have a flight
  double margin = 0.25;         // of a segment's length that must lie in the clip before and after it
  double min_step_s = 0.2;      // shorter: no step, not kept
  double max_step_s = 2.5;      // longer: no step, not kept
  double duration_ratio = 1.5;  // a step longer or shorter than the clip's median step by this factor is not steady
  double slow_ratio = 0.85;     // steps in a row next to a start, a stop or the clip's ends that are slower than this
                                // part of the clip's median step speed are not steady
  double max_drift_rad = 1.05;  // pelvis course against heading; more is walking sideways or backwards, not steady
};

/// Cuts a clip at its key frames into segments, classes by (start, end) key frame (Du 3.1.2, Fig. 3.2, 3.5), in time
/// order. For walking there are six:
///  - left_walk, right_walk: from the landing of the other foot to the landing of this one;
///  - left_first_start, right_first_start: from standing (or a double stance) to the first landing, of this foot;
///    Where the clip is cut just after its walker set off, its slow first step is the start: from a landing, at which both feet
///    stand (so its first key frame counts as a double stance), to the next one. `slow_step` tells it from a start out of standing;
///  - left_end, right_end: from the landing of the other foot to standing, where this foot makes the last step. When
///    that step closes the feet it needs no key frame of its own; when it has one, it is passed over.
///    A slow last step is an end in the same way.
/// Neighbouring segments share their cut. Pieces between two landings of the same foot (a landing was missed), of
/// standing only, of impossible duration, or without a margin in the clip are left out. A start may use standing frames
/// as its margin, an end likewise; both are part of the clip.
///
/// A slow first (last) step is slower than `slow_ratio` of the clip's median step, slower than its neighbour in the clip, and a sound step
/// in every other respect.
///
/// Kept but not steady: the step next to a start or a stop; steps in a row from there, or from the ends of the clip,
/// that are slow against the clip's median step; steps of odd duration, sideways, backwards, with a flight (walking only)
/// or without a swing; any segment over frames in which the recording freezes while the body moves.
/// @param keyframes  in time order, as DetectKeyframes gives them.
/// @throws std::invalid_argument when key frames are out of order or outside the clip, or leg roles are missing.
std::vector<Segment> Decompose(const MotionClip& clip, int clip_index, const std::vector<Keyframe>& keyframes,
                               const DecompositionOptions& options = {});

}  // namespace morphograph
