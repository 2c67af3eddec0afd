#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "primitives/keyframe.h"
#include "primitives/keyframe_cues.h"
#include "primitives/keyframe_labels.h"

namespace morphograph {

/// A clip in which somebody marked key frames, all of them: what is not marked teaches what is none.
struct KeyframeExamples {
  const MotionClip* clip = nullptr;
  std::vector<LabelledFrame> labels;  // frames of `clip`
};

/// A key frame found by likeness to labelled ones.
struct LearnedKeyframe {
  double frame = 0;   // sub-frame position in the clip
  std::string label;  // of the example it resembles
  double depth = 0;   // distance to the nearest example over the greatest such distance around: 0 the same, 1 no likeness
};

struct LearnedKeyframeOptions {
  double window_s = 0.07;        // three poses are compared: at the frame, and this far before and after it
  double search_rate_hz = 30;    // candidates are searched at this rate, then refined at the clip's own
  double tolerance_s = 0.1;      // a candidate this near to a label of its kind counts as found, when thresholds are set
  int cues = 3;                  // turning points that agree on the time of a key frame (see TimingCue)
  double cue_reach_s = 0.15;     // how far off a candidate may be for them to right it
  double spacing = 0.5;          // least time between two of a kind, as part of the least seen in the examples
  double min_seen_s = 0.12;      // a key frame this close to the end of the clip cannot be told from a graze (see KeyframeOptions)
};

/// Finds key frames of any action by the nearest labelled example (Du 4.2.2).
///
/// The measure is the frame distance of Du Eq. 3.1 over windows of three poses (see PoseWindow) aligned as one, so that examples serve
/// other bodies, frame rates, skeletons and tilted floors. A candidate is a local minimum of a label's distance that is the least of all
/// labels' there. Then it moves to where the turning points that go with the labels say (see TimingCue): the likest pose
/// of a slow walk to examples of fast ones comes early, the turning points do not.
///
/// Departures: weights are learned from the examples (see DiscriminantWeights), not set by depth in the hierarchy. Where labels name a
/// side ("left_strike", "right_strike"), mirrored examples teach the other side. The threshold, which Du sets by hand on the distance, is
/// set on its depth, which does not grow with style or body: the one with the best F1 score when each example clip is searched with the
/// examples of the other clips. Wrong candidates that are wrong for another reason than likeness have no say in it: those beside
/// a label of their kind came out at the wrong time, and near the ends of a clip people leave real ones unmarked.
class LearnedKeyframeDetector {
 public:
  /// @throws std::invalid_argument when no label lies in any clip, or a clip lacks a role of EvaluationRoles.
  explicit LearnedKeyframeDetector(const std::vector<KeyframeExamples>& examples, const LearnedKeyframeOptions& options = {});

  /// Key frames in time order; none in the first half of `window_s` nor in the last `min_seen_s` of a clip.
  /// @throws std::invalid_argument when the clip lacks a role of EvaluationRoles.
  std::vector<LearnedKeyframe> Detect(const MotionClip& clip) const;

  /// Greatest accepted depth (see LearnedKeyframe).
  double threshold() const { return threshold_; }

 private:
  // What is measured of a clip once.
  struct Features {
    double rate_hz = 0;
    std::vector<Eigen::Matrix3Xd> poses;
    Eigen::MatrixXd signals;
  };
  // Labelled frames of one example clip or of its mirror image.
  struct Lesson {
    int clip = 0;
    Features features;
    std::map<std::string, std::vector<double>> frames;  // by label, in time order
  };
  struct Kind {
    std::string label;
    std::vector<Eigen::Matrix3Xd> examples;
    std::vector<int> clips;  // in which example clip each stands
    std::vector<TimingCue> cues;
    double spacing_s = 0;
  };
  struct Candidate {
    double frame = 0;
    int kind = 0;
    double depth = 0;
  };

  static Features Measure(std::vector<Eigen::Matrix3Xd> poses, double rate_hz);
  void SetKinds(const std::vector<Lesson>& lessons);
  void SetWeights(const std::vector<Lesson>& lessons);
  void SetThreshold(const std::vector<KeyframeExamples>& examples, const std::vector<Lesson>& lessons);
  std::vector<Candidate> Candidates(const Features& clip, int without_clip) const;
  bool TeachesThreshold(const Candidate& wrong, const KeyframeExamples& example) const;
  void DropCrowded(double rate_hz, std::vector<Candidate>* candidates) const;

  LearnedKeyframeOptions options_;
  std::vector<Kind> kinds_;  // by label, sorted
  Eigen::VectorXd weights_;  // of the points of a window
  double threshold_ = 0;     // greatest accepted depth
};

/// The walking key frames among those found (see WalkingLabel).
std::vector<Keyframe> WalkingKeyframes(const std::vector<LearnedKeyframe>& found);

}  // namespace morphograph
