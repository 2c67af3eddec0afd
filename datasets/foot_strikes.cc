#include "datasets/foot_strikes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/virtual_sensors.h"

namespace morphograph {
namespace {

constexpr double kStillWindow_s = 0.05;      // to both sides
constexpr double kStillDeviation_m_s2 = 1.2;
constexpr double kNearGravity_m_s2 = 2;
constexpr double kLeastPlanted_s = 0.06;
constexpr double kLeastSwing_s = 0.25, kMostSwing_s = 1.5;  // from planted to planted
constexpr double kLanding_s = 0.3, kTakeOff_s = 0.1;
constexpr double kPeakShare = 0.6, kOnsetShare = 0.5;

}  // namespace

std::vector<std::pair<int, int>> StillPhases(const Eigen::Matrix3Xd& accelerations, double rate_hz, double least_s) {
  if (!(rate_hz > 0)) throw std::invalid_argument("StillPhases: the rate must be positive");
  const int samples = static_cast<int>(accelerations.cols()), half = std::max(1, static_cast<int>(std::lround(kStillWindow_s * rate_hz)));
  std::vector<char> still(static_cast<std::size_t>(samples), 0);
  for (int i = 0; i < samples; ++i) {
    if (std::abs(accelerations.col(i).norm() - kGravity_m_s2) > kNearGravity_m_s2) continue;
    const int first = std::max(0, i - half), last = std::min(samples - 1, i + half);
    const auto window = accelerations.middleCols(first, last - first + 1);
    const Eigen::Vector3d mean = window.rowwise().mean();
    still[static_cast<std::size_t>(i)] = (window.colwise() - mean).colwise().squaredNorm().mean() < kStillDeviation_m_s2 * kStillDeviation_m_s2;
  }
  std::vector<std::pair<int, int>> phases;
  for (int first = 0; first < samples;) {
    int last = first;
    if (!still[static_cast<std::size_t>(first)]) {
      ++first;
      continue;
    }
    while (last + 1 < samples && still[static_cast<std::size_t>(last) + 1]) ++last;
    if (last - first + 1 >= least_s * rate_hz) phases.emplace_back(first, last);
    first = last + 1;
  }
  return phases;
}

std::vector<double> FootStrikeTimes(const Eigen::Matrix3Xd& accelerations, double rate_hz) {
  const std::vector<std::pair<int, int>> planted = StillPhases(accelerations, rate_hz, kLeastPlanted_s);
  const auto jerk = [&](int i) { return (accelerations.col(i + 1) - accelerations.col(i - 1)).norm() * rate_hz / 2; };
  std::vector<double> times;
  for (std::size_t p = 0; p + 1 < planted.size(); ++p) {
    const int lift = planted[p].second, flat = planted[p + 1].first;
    if (flat - lift < kLeastSwing_s * rate_hz || flat - lift > kMostSwing_s * rate_hz) continue;
    const int first = std::max(lift + static_cast<int>(kTakeOff_s * rate_hz), flat - static_cast<int>(kLanding_s * rate_hz));
    double largest = 0;
    for (int i = first; i <= flat; ++i) largest = std::max(largest, jerk(i));
    int peak = first;
    while (peak < flat && !(jerk(peak) >= kPeakShare * largest && jerk(peak) >= jerk(peak + 1))) ++peak;
    int onset = peak;
    while (onset > first && jerk(onset) > kOnsetShare * jerk(peak)) --onset;
    times.push_back(onset / rate_hz);
  }
  return times;
}

}  // namespace morphograph
