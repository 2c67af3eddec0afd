#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "datasets/contact_detector.h"
#include "graph/graph_builder.h"
#include "graph/motion_graph.h"
#include "primitives/step_vector.h"

namespace morphograph {

/// A clip made ready to learn from: the model's skeleton, at most kWorkRate_hz, contacts found.
struct PreparedClip {
  MotionClip clip;
  ContactTrack contacts;
  bool made = false;
  int source = 0;  // equal for the copies of one captured clip
  std::string other_action = {};  // see TrainingClip

  const std::string& ActionOr(const std::string& usual) const { return other_action.empty() ? usual : other_action; }
};

/// A segment of the capture, one step.
struct TrainingStep {
  int clip = 0;
  StepSpan span;
  std::string primitive;  // "left_walk", …
  KeyframeLabel start = KeyframeLabel::kRightStance;
  KeyframeLabel end = KeyframeLabel::kLeftStance;
  int previous = -1;  // index of the step directly before it in the same clip
  bool steady = true;
  bool slow_step = false;  // a start or an end that is a slow step of a walk (see Segment)
};

/// Whether a foot lands there while the other foot walks on.
inline bool IsWalking(KeyframeLabel label) {
  return label == KeyframeLabel::kLeftStance || label == KeyframeLabel::kRightStance;
}
/// A step between two landings, neither a start nor an end.
inline bool IsWalkStep(const TrainingStep& step) { return IsWalking(step.start) && IsWalking(step.end); }

/// Steps of one kind, style and action, indices into the list of steps.
struct StepClass {
  std::string other_action;  // see TrainingClip
  std::string style;
  std::string primitive;
  std::vector<int> members;
};

/// Finds the steps of every clip (key frames, then decomposition), clip after clip, in time order.
/// @param action  of clips that show no other. @param find_keyframes  of these; when empty, by the features of the action.
/// @throws DatasetError naming the clip whose key frames cannot be found.
std::vector<TrainingStep> FindSteps(const std::vector<PreparedClip>& clips, int jobs, const std::string& action,
                                    const KeyframeFinder& find_keyframes = {});

/// Decides which slow first and last steps become starts and ends, style by style and side by side.
///
/// Starts out of standing and slow first steps are not alike, and one primitive is not learned from both: where a style has
/// `fewest` of the former, or fewer than that of the latter, its slow steps go back to the walking steps, as ones that are not steady.
/// @return notes on those that were too few.
std::vector<std::string> SettleSlowSteps(const std::vector<PreparedClip>& clips, const std::string& action, int fewest,
                                         std::vector<TrainingStep>* steps);

/// How notes name a primitive: "left_walk (elderly)", "left_end (elderly, run)".
std::string NameInNotes(const std::string& primitive, const std::string& style, const std::string& other_action);

/// What a step is called as a walking step: a slow first step is one too, other steps keep their name.
std::string WalkingNameOf(const TrainingStep& step, const std::string& action);

/// Groups steps by action, style and primitive, sorted by name, the usual action first.
std::vector<StepClass> GroupSteps(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps);

/// Joints that move at all in some clip, the moving root first.
std::vector<int> FindActiveJoints(const std::vector<PreparedClip>& clips);

/// Heel offsets, standing and lowest heights over the clips of a style.
FeetGeometry MeasureFeet(const std::vector<const PreparedClip*>& clips);

}  // namespace morphograph
