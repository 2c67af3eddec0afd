#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

enum class Foot { kLeft, kRight };
inline std::string_view FootName(Foot foot) { return foot == Foot::kLeft ? "left" : "right"; }

/// Frames [first, last] in which a foot stands.
struct ContactInterval {
  Foot foot = Foot::kLeft;
  int first = 0;
  int last = 0;
};

struct ContactOptions {
  double height_m = 0.045;     // above the local floor
  double speed_m_s = 0.7;
  double max_gap_s = 0.06;     // closed
  double min_contact_s = 0.12; // dropped when shorter
  double heel_behind_m = 0.05; // heel = point fixed in the foot, this far behind the ankle, at ball height
};

/// Feet on the floor, floor found from the clip itself.
struct ContactTrack {
  /// One row each: left heel, left ball, right heel, right ball; 1 where planted. (4 x frames)
  Eigen::Array<std::uint8_t, 4, Eigen::Dynamic> planted;
  std::vector<ContactInterval> intervals;  // per foot: heel or ball, gaps closed, in time order
  Eigen::VectorXd ground_m;                // (frames) height of the local floor under the body
  Eigen::Matrix3Xd heels[2], balls[2];     // world positions per foot (3 x frames)
};

/// Finds contacts by height above the local floor and speed (shared/data README, keyframes section). The floor is
/// interpolated through the stances, so a tilted floor does not matter.
/// @throws std::invalid_argument when knees, ankles or toes have no role.
ContactTrack DetectContacts(const MotionClip& clip, const ContactOptions& options = {});

}  // namespace morphograph
