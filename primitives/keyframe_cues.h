#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace morphograph {

/// Signals of a clip whose turning points may mark a key frame, as rows (signals x frames), low-passed at 10 Hz: for every joint the
/// reach ahead of the body, its vertical speed and its distance from the root; for every pair of joints how far they are apart.
/// None depends on heading, place or (poses being in leg lengths) size.
///
/// @param poses  the joints of EvaluationRoles, in leg lengths.
Eigen::MatrixXd CueSignals(const std::vector<Eigen::Matrix3Xd>& poses, double frame_rate_hz);

/// A rule "the key frame lies `offset_s` after a turning point of this signal", learned from labelled clips.
struct TimingCue {
  int signal = 0;        // row of CueSignals
  bool maximum = true;   // or minimum
  double offset_s = 0;   // key frame minus turning point: the median over the examples
  double error_s = 0;    // mean distance to the labels when started near them, capped
};

/// Signals and labels of one example clip.
struct CueExample {
  const Eigen::MatrixXd* signals = nullptr;
  double frame_rate_hz = 0;
  std::vector<double> frames;  // labels of one kind
};

/// The best cues of a kind, at most `count`, best first. A cue is judged by how near it comes to the labels when it starts
/// from a time that is off by up to `reach_s`, as a rough detector's is. Those that nearly all labels do not have are left out.
std::vector<TimingCue> LearnTimingCues(const std::vector<CueExample>& examples, double reach_s, int count);

/// The median of what the cues say about a key frame near `frame`; nothing where none has a turning point within `reach_s`.
std::optional<double> RefineByCues(const std::vector<TimingCue>& cues, const Eigen::MatrixXd& signals, double frame_rate_hz,
                                   double frame, double reach_s);

}  // namespace morphograph
