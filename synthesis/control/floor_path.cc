#include "synthesis/control/floor_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace morphograph {
namespace {

constexpr double kSamePoint_m = 1e-3;
constexpr double kSplineStep_m = 0.02;

// The spline's piece from b to c; knots are spaced by the square root of the distance.
Eigen::Vector2d CatmullRom(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d, double t) {
  const double ab = std::sqrt((b - a).norm()), bc = std::sqrt((c - b).norm()), cd = std::sqrt((d - c).norm());
  const double t1 = ab, t2 = t1 + bc, t3 = t2 + cd;
  const double u = t1 + t * bc;
  const auto mix = [u](const Eigen::Vector2d& p, const Eigen::Vector2d& q, double from, double to) -> Eigen::Vector2d {
    return ((to - u) * p + (u - from) * q) / (to - from);
  };
  const Eigen::Vector2d a1 = mix(a, b, 0, t1), a2 = mix(b, c, t1, t2), a3 = mix(c, d, t2, t3);
  const Eigen::Vector2d b1 = mix(a1, a2, 0, t2), b2 = mix(a2, a3, t1, t3);
  return mix(b1, b2, t1, t2);
}

std::vector<Eigen::Vector2d> Smoothed(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> line;
  const size_t last = points.size() - 1;
  for (size_t i = 0; i < last; ++i) {
    // Beyond its ends the line is taken to go on as it began.
    const Eigen::Vector2d before = i > 0 ? points[i - 1] : Eigen::Vector2d(2 * points[0] - points[1]);
    const Eigen::Vector2d after = i + 2 <= last ? points[i + 2] : Eigen::Vector2d(2 * points[last] - points[last - 1]);
    const int pieces = std::clamp(static_cast<int>(std::ceil((points[i + 1] - points[i]).norm() / kSplineStep_m)), 1, 5000);
    for (int k = 0; k < pieces; ++k) line.push_back(CatmullRom(before, points[i], points[i + 1], after, k / double{1.0 * pieces}));
  }
  line.push_back(points[last]);
  return line;
}

}  // namespace

double HeadingOfDirection(const Eigen::Vector2d& direction) { return std::atan2(direction.x(), direction.y()); }
Eigen::Vector2d DirectionOfHeading(double heading_rad) { return {std::sin(heading_rad), std::cos(heading_rad)}; }

FloorPath::FloorPath(const std::vector<Eigen::Vector2d>& points_m, bool smooth) {
  for (const Eigen::Vector2d& point : points_m) {
    if (!point.allFinite()) throw std::invalid_argument("FloorPath: a point is not finite");
    if (corners_.empty() || (point - corners_.back()).norm() >= kSamePoint_m) corners_.push_back(point);
  }
  if (corners_.size() < 2) throw std::invalid_argument("FloorPath: needs two points that differ");
  if (smooth && corners_.size() > 2) corners_ = Smoothed(corners_);
  lengths_.push_back(0);
  for (size_t i = 1; i < corners_.size(); ++i) {
    const Eigen::Vector2d piece = corners_[i] - corners_[i - 1];
    lengths_.push_back(lengths_.back() + piece.norm());
    directions_.push_back(piece.normalized());
  }
}

size_t FloorPath::PieceAt(double along_m) const {
  const auto above = std::upper_bound(lengths_.begin(), lengths_.end(), along_m);
  return static_cast<size_t>(std::clamp<std::ptrdiff_t>(above - lengths_.begin() - 1, 0, static_cast<std::ptrdiff_t>(lengths_.size()) - 2));
}

Eigen::Vector2d FloorPath::Direction(double along_m) const {
  return directions_[PieceAt(along_m)];
}

Eigen::Vector2d FloorPath::At(double along_m) const {
  const size_t i = PieceAt(along_m);
  return corners_[i] + (along_m - lengths_[i]) * directions_[i];
}

double FloorPath::Heading(double along_m) const { return HeadingOfDirection(Direction(along_m)); }

FloorPath::Nearest FloorPath::NearestTo(const Eigen::Vector2d& point_m, double from_m, double to_m) const {
  from_m = std::clamp(from_m, 0.0, length_m());
  to_m = std::clamp(to_m, from_m, length_m());
  Nearest nearest;
  nearest.distance_m = -1;  // squared, until the end
  for (size_t i = PieceAt(from_m); i + 1 < corners_.size() && (lengths_[i] <= to_m || nearest.distance_m < 0); ++i) {
    const Eigen::Vector2d& direction = directions_[i];
    const double low = std::max(from_m, lengths_[i]), high = std::max(low, std::min(to_m, lengths_[i + 1]));
    const double along = std::clamp(lengths_[i] + direction.dot(point_m - corners_[i]), low, high);
    const Eigen::Vector2d foot = corners_[i] + (along - lengths_[i]) * direction;
    const double distance2 = (point_m - foot).squaredNorm();
    if (nearest.distance_m < 0 || distance2 < nearest.distance_m) nearest = {along, distance2, foot};
  }
  nearest.distance_m = std::sqrt(nearest.distance_m);
  return nearest;
}

}  // namespace morphograph
