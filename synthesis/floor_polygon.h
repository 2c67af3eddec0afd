#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

// Polygons on the floor: corners (x, z) in metres, the last joined to the first, either sense of turn. Computed by Boost.Geometry.

/// Whether it has three corners or more, and no two of its edges cross or touch but neighbours at their common corner.
bool IsSimplePolygon(const std::vector<Eigen::Vector2d>& corners_m);

/// Square metres, never negative. @pre IsSimplePolygon(corners_m)
double PolygonArea(const std::vector<Eigen::Vector2d>& corners_m);

/// The polygon with fewer corners, its outline moved by `tolerance_m` at most (Douglas and Peucker, 1973). Where that would make the outline
/// cross itself, a finer tolerance is taken, in the end the polygon as it is. @pre IsSimplePolygon(corners_m)
std::vector<Eigen::Vector2d> Simplified(const std::vector<Eigen::Vector2d>& corners_m, double tolerance_m);

}  // namespace morphograph
