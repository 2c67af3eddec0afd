#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "datasets/forward_kinematics.h"
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
  double low_pass_hz = 10;     // of clips above 60 frames a second, before speeds are taken
  double jitter_m = 0.005;      // feet that jitter more are smoothed first, or they would never be slow
  double jittery_low_pass_hz = 4;
  double plane_residual_m = 0.012;  // stances that lie within this (root mean square) of a plane share it as floor
};

/// Floor as a plane: height = height_m + slope . ((x, z) - origin). Across a straight walk only the slope along it
/// can be seen; the slope across is then zero (a strip).
struct FloorPlane {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // (x, z)
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  double height_m = 0;
  double HeightAt(double x, double z) const { return height_m + slope.dot(Eigen::Vector2d(x, z) - origin); }
};

/// Feet on the floor, floor found from the clip itself.
struct ContactTrack {
  /// One row each: left heel, left ball, right heel, right ball; 1 where planted. (4 x frames)
  Eigen::Array<std::uint8_t, 4, Eigen::Dynamic> planted;
  std::vector<ContactInterval> intervals;  // per foot: heel or ball, gaps closed, in time order
  /// (frames) Height at which the ball joint of a foot stands, under the hips: the floor's height plus the thickness
  /// of the foot, which no clip tells apart.
  Eigen::VectorXd ground_m;
  std::optional<FloorPlane> plane;  // where one plane holds all stances; else the floor follows time only
  Eigen::Matrix3Xd heels[2], balls[2];     // world positions per foot (3 x frames)
};

/// Finds contacts by height above the local floor and speed.
///
/// A foot stands where its heel or ball is low and slow; speed is the smaller of backward and forward difference, so
/// that the first frame of a stance counts. The floor goes through the median ball heights of the stances: a plane
/// where one fits them, else interpolated in time, so tilted floors and steps do not matter. The heel is a point fixed
/// in the foot that lies at ball height in flat stances: the slow frames that agree on how far the ankle is above the ball.
/// A contact shorter than `min_contact_s` is dropped at the ends of the clip too, where it cannot be told from a graze. Where the feet jitter, as in raw markerless captures, the track is of
/// smoothed feet (clean recordings: 0.1 to 0.7 mm of white noise on a coordinate, 2.2 mm at most).
/// @throws std::invalid_argument when knees, ankles or toes have no role.
ContactTrack DetectContacts(const MotionClip& clip, const ContactOptions& options = {});

/// The same where the poses of all frames, as WorldPoses(clip) gives them, are at hand already.
/// @throws std::invalid_argument also when there is not one pose a frame.
ContactTrack DetectContacts(const MotionClip& clip, const std::vector<WorldPose>& poses, const ContactOptions& options = {});

}  // namespace morphograph
