#include "datasets/eased_stop.h"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

constexpr double kShortestHold_s = 0.2;
constexpr double kStillWalking_m_s = 0.3;

bool Equal(const MotionClip& clip, int a, int b) {
  if (clip.root_positions().col(a) != clip.root_positions().col(b)) return false;
  for (int j = 0; j < clip.joint_count(); ++j) {
    if (clip.rotation(a, j).angularDistance(clip.rotation(b, j)) > 1e-7) return false;
  }
  return true;
}

}  // namespace

std::optional<int> FindHold(const MotionClip& clip) {
  int first = clip.frame_count() - 1;
  while (first > 0 && Equal(clip, first - 1, first)) --first;
  if (first < 1 || clip.frame_count() - 1 - first < kShortestHold_s * clip.frame_rate_hz()) return std::nullopt;
  const double speed = (clip.root_positions().col(first) - clip.root_positions().col(first - 1)).norm() * clip.frame_rate_hz();
  if (speed < kStillWalking_m_s) return std::nullopt;
  return first;
}

MotionClip EasedStop(const MotionClip& clip, int hold, const EasedStopOptions& options) {
  if (hold < 0 || hold >= clip.frame_count()) {
    throw std::invalid_argument("EasedStop: frame " + std::to_string(hold) + " is not one of the clip's");
  }
  const double rate = clip.frame_rate_hz();
  const double slows = std::max(0.0, hold - rate * options.ease_s / 2);  // frame at which the clock begins to slow
  const double begins = std::max(0.0, std::floor(slows - rate * options.before_s));
  const double ease = 2 * (hold - slows);  // frames that the rest of the motion takes
  const int frames = static_cast<int>(std::ceil(slows - begins + ease + rate * options.stand_s)) + 1;
  MotionClip eased(clip.shared_skeleton(), rate, frames);
  eased.name = clip.name + "_stop";
  eased.style = clip.style;
  for (int f = 0; f < frames; ++f) {
    double source = begins + f;
    if (source > slows) {  // clock rate (1 + cos(pi u)) / 2 over u in [0, 1]
      constexpr double kPi = boost::math::double_constants::pi;
      const double u = ease > 0 ? std::min(1.0, (source - slows) / ease) : 1.0;
      source = slows + ease * (u / 2 + std::sin(kPi * u) / (2 * kPi));
    }
    const int base = std::min(static_cast<int>(source), hold);
    const int next = std::min(base + 1, hold);
    const double t = std::min(source, static_cast<double>(hold)) - base;
    eased.root_positions().col(f) = (1 - t) * clip.root_positions().col(base) + t * clip.root_positions().col(next);
    for (int j = 0; j < clip.joint_count(); ++j) eased.rotation(f, j) = clip.rotation(base, j).slerp(t, clip.rotation(next, j));
  }
  return eased;
}

}  // namespace morphograph
