#include "synthesis/control/floor_area.h"

#include <algorithm>
#include <limits>

namespace morphograph {
namespace {

constexpr double kFar_m = 2;

// Even-odd rule.
bool IsInside(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > point.y()) != (b.y() > point.y()) && point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

}  // namespace

FloorArea::FloorArea(const KeepOutTerm& term) : term_(&term), center_m_(term.center_m), radius_m_(term.radius_m) {
  if (term.polygon_m.empty()) return;
  center_m_.setZero();
  for (const Eigen::Vector2d& corner : term.polygon_m) center_m_ += corner / static_cast<double>(term.polygon_m.size());
  radius_m_ = 0;
  for (const Eigen::Vector2d& corner : term.polygon_m) radius_m_ = std::max(radius_m_, (corner - center_m_).norm());
}

double FloorArea::CircleDepth(const Eigen::Vector2d& point_m, Eigen::RowVector2d* gradient) const {
  const Eigen::Vector2d out = point_m - center_m_;
  const double distance = out.norm();
  if (gradient) *gradient = distance > 0 ? Eigen::RowVector2d(-out.transpose() / distance) : Eigen::RowVector2d(-1, 0);
  return radius_m_ - distance;
}

double FloorArea::Depth(const Eigen::Vector2d& point_m, Eigen::RowVector2d* gradient) const {
  const double of_circle = CircleDepth(point_m, gradient);
  if (term_->polygon_m.empty() || of_circle < -kFar_m) return of_circle;
  double nearest = std::numeric_limits<double>::infinity();
  Eigen::Vector2d foot = Eigen::Vector2d::Zero(), normal = Eigen::Vector2d::UnitX();
  const auto& polygon = term_->polygon_m;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d edge = polygon[i] - polygon[j];
    const double length2 = edge.squaredNorm();
    const double along = length2 > 0 ? std::clamp((point_m - polygon[j]).dot(edge) / length2, 0.0, 1.0) : 0;
    const Eigen::Vector2d candidate = polygon[j] + along * edge;
    if (const double distance = (point_m - candidate).norm(); distance < nearest) {
      nearest = distance;
      foot = candidate;
      if (length2 > 0) normal = Eigen::Vector2d(-edge.y(), edge.x()).normalized();
    }
  }
  const double sign = IsInside(polygon, point_m) ? 1 : -1;
  if (gradient) *gradient = nearest > 1e-12 ? Eigen::RowVector2d(sign * (point_m - foot).transpose() / nearest) : Eigen::RowVector2d(normal.transpose());
  return sign * nearest;
}

}  // namespace morphograph
