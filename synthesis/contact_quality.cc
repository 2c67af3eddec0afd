#include "synthesis/contact_quality.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace morphograph {
namespace {

constexpr double kSkateHeight_m = 0.025;  // height at which a ball no longer counts as sliding

}  // namespace

ContactQuality MeasureContacts(const ContactTrack& contacts, const GroundPlane& ground,
                               double frame_rate_hz) {
  const int frames = static_cast<int>(contacts.balls[0].cols());
  if (frames < 2) {
    throw std::invalid_argument("MeasureContacts: at least 2 frames are needed, not " +
                                std::to_string(frames));
  }
  ContactQuality quality;
  quality.distance_m = Eigen::VectorXd::Zero(frames);
  Eigen::Matrix2Xd ball_height(2, frames), low_height(2, frames);  // above the plane, a row a foot
  for (int side = 0; side < 2; ++side) {
    for (int f = 0; f < frames; ++f) {
      const Eigen::Vector3d ball = contacts.balls[side].col(f), heel = contacts.heels[side].col(f);
      ball_height(side, f) = ball.y() - ground.HeightAt(ball);
      low_height(side, f) = std::min(ball_height(side, f), heel.y() - ground.HeightAt(heel));
    }
  }
  quality.penetration_m = std::max(0.0, -low_height.minCoeff());

  Eigen::VectorXi planted = Eigen::VectorXi::Zero(frames);
  double distance_sum = 0;
  for (const ContactInterval& interval : contacts.intervals) {
    const int side = interval.foot == Foot::kLeft ? 0 : 1;
    for (int f = interval.first; f <= interval.last; ++f) {
      const double distance = std::abs(low_height(side, f));
      distance_sum += distance;
      quality.distance_m[f] += distance;
      ++planted[f];
      ++quality.planted_foot_frames;
    }
  }
  for (int f = 0; f < frames; ++f) {
    if (planted[f] > 1) quality.distance_m[f] /= planted[f];
  }
  if (quality.planted_foot_frames > 0)
    quality.contact_distance_m = distance_sum / quality.planted_foot_frames;

  double skate_sum = 0, planted_sum = 0;
  for (int side = 0; side < 2; ++side) {
    for (int f = 0; f + 1 < frames; ++f) {
      const double height = 0.5 * (ball_height(side, f) + ball_height(side, f + 1));
      if (height >= kSkateHeight_m) continue;
      const double near = std::clamp(2.0 - std::exp2(height / kSkateHeight_m), 0.0, 1.0);
      const Eigen::Vector3d step = contacts.balls[side].col(f + 1) - contacts.balls[side].col(f);
      const double skate = near * std::hypot(step.x(), step.z()) * frame_rate_hz;
      skate_sum += skate;
      if (contacts.planted(2 * side + 1, f) && contacts.planted(2 * side + 1, f + 1)) planted_sum += skate;
    }
  }
  quality.foot_skate_cm_s = 100 * skate_sum / (2 * (frames - 1));
  quality.planted_skate_cm_s = 100 * planted_sum / (2 * (frames - 1));
  return quality;
}

}  // namespace morphograph
