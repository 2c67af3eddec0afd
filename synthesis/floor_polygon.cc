#include "synthesis/floor_polygon.h"

// Boost 1.74 includes one of its own old headers.
#define BOOST_ALLOW_DEPRECATED_HEADERS
#include <boost/geometry/algorithms/area.hpp>
#include <boost/geometry/algorithms/intersects.hpp>
#include <boost/geometry/algorithms/simplify.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/ring.hpp>
#include <boost/geometry/strategies/strategies.hpp>
#include <cmath>

namespace morphograph {
namespace {

namespace bg = boost::geometry;
using FloorPoint = bg::model::d2::point_xy<double>;
using Ring = bg::model::ring<FloorPoint>;  // closed: the first corner once more at the end

Ring RingOf(const std::vector<Eigen::Vector2d>& corners_m) {
  Ring ring;
  for (const Eigen::Vector2d& corner : corners_m) ring.emplace_back(corner.x(), corner.y());
  if (!ring.empty()) ring.push_back(ring.front());
  return ring;
}

bool IsSimple(const Ring& ring) {
  if (ring.size() < 4) return false;
  for (std::size_t i = 1; i < ring.size(); ++i) {
    if (ring[i].x() == ring[i - 1].x() && ring[i].y() == ring[i - 1].y()) return false;
  }
  // An outline that goes back on itself encloses nothing there, and intersects() is not asked about such spikes.
  for (std::size_t i = 1; i < ring.size(); ++i) {
    const FloorPoint &before = ring[i - 1], &at = ring[i], &after = i + 1 < ring.size() ? ring[i + 1] : ring[1];
    const Eigen::Vector2d in(at.x() - before.x(), at.y() - before.y()), out(after.x() - at.x(), after.y() - at.y());
    if (in.x() * out.y() == in.y() * out.x() && in.dot(out) < 0) return false;
  }
  return !bg::intersects(ring);
}

}  // namespace

bool IsSimplePolygon(const std::vector<Eigen::Vector2d>& corners_m) { return IsSimple(RingOf(corners_m)); }

double PolygonArea(const std::vector<Eigen::Vector2d>& corners_m) { return std::abs(bg::area(RingOf(corners_m))); }

std::vector<Eigen::Vector2d> Simplified(const std::vector<Eigen::Vector2d>& corners_m, double tolerance_m) {
  const Ring ring = RingOf(corners_m);
  for (int halvings = 0; halvings < 5; ++halvings, tolerance_m /= 2) {
    Ring fewer;
    bg::simplify(ring, fewer, tolerance_m);
    if (!IsSimple(fewer)) continue;
    std::vector<Eigen::Vector2d> corners;
    for (std::size_t i = 0; i + 1 < fewer.size(); ++i) corners.emplace_back(fewer[i].x(), fewer[i].y());
    return corners;
  }
  return corners_m;
}

}  // namespace morphograph
