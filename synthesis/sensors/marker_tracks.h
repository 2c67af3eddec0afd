#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/placements.h"
#include "synthesis/sensors/motion_base.h"

namespace morphograph {

/// Where markers on the body are, all frames of a base: (3 * markers x frames), metres, seen from the floor below the moving root and from its heading.
/// @throws std::invalid_argument for a joint that the skeleton does not have.
Eigen::MatrixXf MarkerTracks(const MotionBase& base, const std::vector<Placement>& markers);

/// A frame on the floor that a few markers define: their mean place, and the turn that best brings them onto their usual places (least squares, about
/// the vertical). Heights are kept.
///
/// Liu (4.1) takes the marker at the neck as origin and the shoulders as x axis, which asks for three markers beside the chosen few; this
/// frame needs none but those. With three markers so placed it is nearly theirs.
class MarkerFrame {
 public:
  MarkerFrame() = default;
  /// @param usual  (3 x markers): places in a body's frame; only relative ones on the floor count.
  explicit MarkerFrame(const Eigen::Matrix3Xd& usual);

  /// From the markers' own space to the frame: turn about +Y, then what the floor position of the frame's origin was.
  struct Place {
    double x_m = 0, z_m = 0;
    double cosine = 1, sine = 0;  // of the frame's heading
    Eigen::Vector3d Into(const Eigen::Vector3d& point) const;
    Eigen::Vector3d OutOf(const Eigen::Vector3d& point) const;
    double heading_rad() const;
  };
  /// @param points  (3 * markers), the markers of the constructor.
  Place Fit(const Eigen::Ref<const Eigen::VectorXd>& points) const;

 private:
  Eigen::Matrix2Xd usual_;  // (x, z), about their mean
};

}  // namespace morphograph
