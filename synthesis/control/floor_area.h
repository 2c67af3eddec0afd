#pragma once

#include <Eigen/Core>

#include "synthesis/control/control_terms.h"

namespace morphograph {

/// How deep a point on the floor lies inside an area (m): the distance to its border, negative outside.
/// @param gradient  if given, d depth / d point; a unit vector.
double DepthInside(const KeepOutTerm& area, const Eigen::Vector2d& point_m, Eigen::RowVector2d* gradient = nullptr);

}  // namespace morphograph
