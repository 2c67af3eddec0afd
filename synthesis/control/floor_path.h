#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

/// A line on the floor by its arc length: straight pieces between points, or a centripetal Catmull-Rom spline through them
/// (Yuksel et al. 2011), which neither loops nor overshoots between its points.
class FloorPath {
 public:
  /// @param points_m  (x, z). Points that follow each other at less than a millimetre count once.
  /// @throws std::invalid_argument where fewer than two points are left, or one is not finite.
  explicit FloorPath(const std::vector<Eigen::Vector2d>& points_m, bool smooth = false);

  double length_m() const { return lengths_.back(); }
  /// The point at an arc length; the line goes on straight before its beginning and after its end.
  Eigen::Vector2d At(double along_m) const;
  /// Unit direction there.
  Eigen::Vector2d Direction(double along_m) const;
  /// Heading there, radians: 0 along +Z, pi/2 along +X.
  double Heading(double along_m) const;

  struct Nearest {
    double along_m = 0;
    double distance_m = 0;
    Eigen::Vector2d point_m = Eigen::Vector2d::Zero();
  };
  /// The nearest point of the line between two arc lengths (clamped to it), the first of equals.
  Nearest NearestTo(const Eigen::Vector2d& point_m, double from_m, double to_m) const;
  Nearest NearestTo(const Eigen::Vector2d& point_m) const { return NearestTo(point_m, 0, length_m()); }

 private:
  size_t PieceAt(double along_m) const;

  std::vector<Eigen::Vector2d> corners_;
  std::vector<double> lengths_;               // from the beginning to each corner
  std::vector<Eigen::Vector2d> directions_;   // of the pieces between them
};

/// Yaw of a direction on the floor (x, z), and the reverse.
double HeadingOfDirection(const Eigen::Vector2d& direction);
Eigen::Vector2d DirectionOfHeading(double heading_rad);

}  // namespace morphograph
