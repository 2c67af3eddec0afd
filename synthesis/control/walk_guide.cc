#include "synthesis/control/walk_guide.h"

#include <cmath>

namespace morphograph {

double SpeedAt(const std::vector<SpeedTerm::Knot>& profile, double time_s) {
  size_t i = 0;
  while (i < profile.size() && profile[i].time_s <= time_s) ++i;
  if (i == 0) return profile.front().speed_m_s;
  if (i == profile.size()) return profile.back().speed_m_s;
  const auto &a = profile[i - 1], &b = profile[i];
  return a.speed_m_s + (b.speed_m_s - a.speed_m_s) * (time_s - a.time_s) / (b.time_s - a.time_s);
}

double SignedAngle(double a, double b) { return std::remainder(a - b, 2 * M_PI); }

}  // namespace morphograph
