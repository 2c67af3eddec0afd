#pragma once

#include <Eigen/Core>

#include "synthesis/control/control_terms.h"

namespace morphograph {

/// An area of the floor to keep out of.
class FloorArea {
 public:
  /// @param term  must outlive the area.
  explicit FloorArea(const KeepOutTerm& term);

  /// How deep a point lies inside (m): the distance to the border, negative outside. Of polygons more than two metres away, the distance to the
  /// circle about them, which is no more than that.
  /// @param gradient  if given, d depth / d point; a unit vector.
  double Depth(const Eigen::Vector2d& point_m, Eigen::RowVector2d* gradient = nullptr) const;

 private:
  double CircleDepth(const Eigen::Vector2d& point_m, Eigen::RowVector2d* gradient) const;

  const KeepOutTerm* term_;
  Eigen::Vector2d center_m_;  // of a circle about the area
  double radius_m_;
};

/// The same for one point.
inline double DepthInside(const KeepOutTerm& term, const Eigen::Vector2d& point_m) { return FloorArea(term).Depth(point_m); }

}  // namespace morphograph
