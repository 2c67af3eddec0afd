#pragma once

#include "datasets/contact_detector.h"

namespace morphograph {

/// The contact plane of a clip (Du 4.5.1): height = height_m + slope_x x + slope_z z.
///
/// It is the plane on which the *contact points* rest, not the soles: a ball joint stands a few centimetres
/// above the real floor, and how far depends on the skeleton. Heights above this plane are 0 for a foot in
/// flat stance, so one measure serves every skeleton.
struct GroundPlane {
  double height_m = 0;
  double slope_x = 0;
  double slope_z = 0;

  double HeightAt(double x_m, double z_m) const { return height_m + slope_x * x_m + slope_z * z_m; }
  double HeightAt(const Eigen::Vector3d& point) const { return HeightAt(point.x(), point.z()); }
};

/// Fits the plane through the stances of both feet.
///
/// Each planted interval gives one point: the median ball of its frames in which the ball is slower than 0.3
/// m/s (a foot that rolls over its toes is still "planted" but no longer flat). Least squares with a ridge on
/// the slopes (a walk along a line cannot tell the slope across it; the ridge keeps the plane from hiding a
/// height difference between left and right), reweighted by Huber's weights so that one bad stance does not
/// tilt it. Unlike `ContactTrack::plane` there is always a plane: stances that do not share one are an error
/// to be measured here. Where no foot stands still the plane is level, at the fifth percentile of the lower
/// of both balls.
/// @throws std::invalid_argument when the track has no frame or the rate is not positive.
GroundPlane FitGroundPlane(const ContactTrack& contacts, double frame_rate_hz);

}  // namespace morphograph
