#pragma once

#include <vector>

#include "datasets/contact_detector.h"

namespace morphograph::testing {

/// Two feet that alternately stand for `stance` frames and swing 10 cm high for as many, walking along +Z;
/// balls and heels stand at `stance_height_m`. Made for measures whose answer is then known.
inline ContactTrack AlternatingFeet(int frames, int stance = 15, double stance_height_m = 0.04) {
  ContactTrack track;
  track.planted = Eigen::Array<std::uint8_t, 4, Eigen::Dynamic>::Zero(4, frames);
  track.ground_m = Eigen::VectorXd::Constant(frames, stance_height_m);
  for (int side = 0; side < 2; ++side) {
    track.balls[side] = track.heels[side] = Eigen::Matrix3Xd::Zero(3, frames);
    double z = side == 0 ? 0.0 : 0.3;
    for (int f = 0; f < frames; ++f) {
      const bool stands = (f / stance) % 2 == side;
      if (!stands) z += 0.6 / stance;
      const Eigen::Vector3d ball(side == 0 ? 0.1 : -0.1, stance_height_m + (stands ? 0.0 : 0.1), z);
      track.balls[side].col(f) = ball;
      track.heels[side].col(f) = ball - Eigen::Vector3d(0, 0, 0.18);
      track.planted(2 * side, f) = track.planted(2 * side + 1, f) = stands;
    }
  }
  for (int first = 0; first < frames; first += stance) {
    track.intervals.push_back({(first / stance) % 2 == 0 ? Foot::kLeft : Foot::kRight, first,
                               std::min(first + stance, frames) - 1});
  }
  return track;
}

}  // namespace morphograph::testing
