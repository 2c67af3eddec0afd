#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>

namespace morphograph {

/// A number of a report, to five decimals: dividing by a whole number gives the double nearest to the decimal ("0.04"); + 0.0 turns -0
/// into 0.
inline double Decimals5(double value) { return std::round(value * 1e5) / 1e5 + 0.0; }

/// [x, z]
inline nlohmann::ordered_json FloorPointJson(const Eigen::Vector2d& point_m) {
  return nlohmann::ordered_json::array({Decimals5(point_m.x()), Decimals5(point_m.y())});
}

}  // namespace morphograph
