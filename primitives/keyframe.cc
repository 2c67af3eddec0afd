#include "primitives/keyframe.h"

namespace morphograph {

std::string_view KeyframeLabelName(KeyframeLabel label) {
  switch (label) {
    case KeyframeLabel::kLeftStance: return "left_stance";
    case KeyframeLabel::kRightStance: return "right_stance";
    case KeyframeLabel::kDoubleStance: return "double_stance";
    case KeyframeLabel::kStanding: return "standing";
  }
  return "";
}

}  // namespace morphograph
