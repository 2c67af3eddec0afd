#pragma once

#include <vector>

#include "primitives/keyframe.h"

namespace morphograph {

/// A key frame that should be found, and the frames that count as finding it.
struct ReferenceKeyframe {
  double frame = 0;  // where it was marked; distortion is measured from here
  double first = 0;  // [first, last]: where the mark is right, the tolerance aside; e.g. the double contact
  double last = 0;
  KeyframeLabel label = KeyframeLabel::kLeftStance;
  bool doubtful = false;  // neither missed nor wrong, whether found or not
};

/// How well key frames were extracted (Du 4.2.3).
struct KeyframeScore {
  int true_positives = 0;
  int false_positives = 0;
  int false_negatives = 0;
  double distortion_sum_s = 0;

  double precision() const;        // Eq. 4.1; 1 where nothing was extracted
  double extraction_rate() const;  // Eq. 4.2; 1 where nothing is to be found
  /// Eq. 4.3 in seconds. Divided by the number found, not by the number of labels as printed: a missed key frame
  /// has no distance and would lower the mean.
  double distortion_s() const;
  KeyframeScore& operator+=(const KeyframeScore& other);
};

/// Matches extracted key frames of the labels that occur in `judged` one to one with the reference, in time order,
/// the greatest possible number of pairs. A pair has the same label and lies within `tolerance_s` of [first, last].
KeyframeScore EvaluateKeyframes(const std::vector<Keyframe>& extracted, const std::vector<ReferenceKeyframe>& reference,
                                const std::vector<KeyframeLabel>& judged, double frame_rate_hz, double tolerance_s);

}  // namespace morphograph
