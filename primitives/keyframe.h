#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace morphograph {

/// A key frame of walking. The side is the foot that has just landed (Du 3.1).
enum class KeyframeLabel { kLeftStance, kRightStance, kDoubleStance, kStanding };

std::string_view KeyframeLabelName(KeyframeLabel label);  // "left_stance", … as in CONTRACT.md

struct Keyframe {
  double frame = 0;  // sub-frame position, frames from the first frame of the clip given
  KeyframeLabel label = KeyframeLabel::kLeftStance;
};

}  // namespace morphograph
