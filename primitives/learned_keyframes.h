#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "primitives/keyframe.h"
#include "primitives/keyframe_labels.h"

namespace morphograph {

/// A clip in which somebody marked key frames, all of them: what is not marked teaches what is none.
struct KeyframeExamples {
  const MotionClip* clip = nullptr;
  std::vector<LabelledFrame> labels;  // frames of `clip`
};

/// A key frame found by likeness to labelled ones.
struct LearnedKeyframe {
  double frame = 0;     // sub-frame position in the clip
  std::string label;    // of the example it resembles
  double distance = 0;  // to the nearest example; mean square over joints and window, in squared leg lengths
};

struct LearnedKeyframeOptions {
  double window_s = 0.07;        // three poses are compared: at the frame, and this far before and after it
  double search_rate_hz = 30;    // candidates are searched at this rate, then refined at the clip's own
  double tolerance_s = 0.1;      // a candidate this near to a label of its kind counts as found, when thresholds are set
  double spacing = 0.5;          // least time between two of a kind, as part of the least seen in the examples
};

/// Finds key frames of any action by the nearest labelled example (Du 4.2.2).
///
/// The measure is the frame distance of Du Eq. 3.1 with equal weights, over three poses aligned as one. Poses are the
/// joints of EvaluationRoles in leg lengths above the lowest of them, so that examples serve other bodies, frame
/// rates, skeletons and tilted floors. A key frame is a local minimum of a label's distance that is the least of all labels' there
/// and below the label's threshold.
///
/// Departure: Du sets the threshold by hand. Here it is the one with the best F1 score when each example clip is searched
/// with the examples of the other clips.
class LearnedKeyframeDetector {
 public:
  /// @throws std::invalid_argument when no label lies in any clip, or a clip lacks a role of EvaluationRoles.
  explicit LearnedKeyframeDetector(const std::vector<KeyframeExamples>& examples, const LearnedKeyframeOptions& options = {});

  /// Key frames in time order. @throws std::invalid_argument when the clip lacks a role of EvaluationRoles.
  std::vector<LearnedKeyframe> Detect(const MotionClip& clip) const;

  /// Largest accepted distance by label.
  std::map<std::string, double> thresholds() const;

 private:
  struct Example {
    Eigen::Matrix3Xd points;  // window of poses side by side
    int clip = 0;             // which example clip it stands in
  };
  struct Kind {
    std::string label;
    std::vector<Example> examples;
    double threshold = 0;
    double spacing_s = 0;
  };
  struct Candidate {
    double frame = 0;
    int kind = 0;
    double distance = 0;
  };

  std::vector<Candidate> Candidates(const std::vector<Eigen::Matrix3Xd>& poses, double rate_hz, int without_clip) const;
  void SetThresholds(const std::vector<KeyframeExamples>& examples, const std::vector<std::vector<Eigen::Matrix3Xd>>& poses);

  LearnedKeyframeOptions options_;
  std::vector<Kind> kinds_;  // by label, sorted
};

/// The walking key frames among those found (see WalkingLabel).
std::vector<Keyframe> WalkingKeyframes(const std::vector<LearnedKeyframe>& found);

}  // namespace morphograph
