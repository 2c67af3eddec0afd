#include "datasets/marker_units.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/quantile.h"

namespace morphograph {
namespace {

constexpr double kStandsOut = 1.25;
constexpr int kFramesLookedAt = 500;
// Two feet side by side, or the whole of a tall body with a raised arm. Less than a factor of ten, so that the ranges of the units do not meet.
constexpr double kLeastExtent_m = 0.25, kMostExtent_m = 2.45;

// Median extent of what is seen of the body along each axis; 0 without two markers at once.
Eigen::Vector3d MedianExtent(const Readings& markers) {
  std::vector<double> extents[3];
  const int stride = std::max(1, markers.sample_count() / kFramesLookedAt);
  for (int f = 0; f < markers.sample_count(); f += stride) {
    Eigen::AlignedBox3d box;
    int seen = 0;
    for (int m = 0; m < markers.sensor_count(); ++m) {
      const Eigen::Vector3d position = markers.values.col(f).segment<3>(3 * m);
      if (!position.allFinite()) continue;
      box.extend(position);
      ++seen;
    }
    if (seen < 2) continue;
    for (int axis = 0; axis < 3; ++axis) extents[axis].push_back(box.sizes()[axis]);
  }
  Eigen::Vector3d median = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3 && !extents[axis].empty(); ++axis) median[axis] = Median(extents[axis]);
  return median;
}

}  // namespace

double MetresPerMarkerUnit(const Readings& markers) {
  const double extent = MedianExtent(markers).maxCoeff();
  for (const double unit : {1.0, 0.01, 0.001}) {
    if (extent * unit >= kLeastExtent_m && extent * unit <= kMostExtent_m) return unit;
  }
  return 1;
}

UpAxis UpAxisOfMarkers(const Readings& markers, UpAxis usual) {
  const Eigen::Vector3d extent = MedianExtent(markers);
  if (extent.y() > kStandsOut * std::max(extent.x(), extent.z())) return UpAxis::kY;
  if (extent.z() > kStandsOut * std::max(extent.x(), extent.y())) return UpAxis::kZ;
  return usual;
}

Readings MarkersInMetres(const Readings& markers, double metres_per_unit, UpAxis up) {
  if (!(metres_per_unit > 0)) throw std::invalid_argument("MarkersInMetres: metres per unit must be positive");
  Readings turned = markers;
  turned.values *= metres_per_unit;
  if (up == UpAxis::kY) return turned;
  for (Eigen::Index m = 0; m < markers.sensor_count(); ++m) {
    const Eigen::RowVectorXd y = turned.values.row(3 * m + 1);
    turned.values.row(3 * m + 1) = turned.values.row(3 * m + 2);
    turned.values.row(3 * m + 2) = -y;
  }
  return turned;
}

}  // namespace morphograph
