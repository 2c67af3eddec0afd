#pragma once

#include <cmath>

namespace morphograph {

/// Clients write degrees, the library computes with radians. Degrees are taken to 1e-9: so far they survive the way there and back, for
/// angles of up to kMaxAngle_deg, and the canonical form of a request names exactly the clip that was made.
inline constexpr double kMaxAngle_deg = 36'000;
inline constexpr double kRadPerDeg = 0.017453292519943295;

inline double RadiansFromDegrees(double angle_deg) { return std::round(angle_deg * 1e9) / 1e9 * kRadPerDeg; }
inline double DegreesFromRadians(double angle_rad) { return std::round(angle_rad / kRadPerDeg * 1e9) / 1e9 + 0.0; }

}  // namespace morphograph
