#include "synthesis/sensors/marker_tracks.h"

#include <cmath>


namespace morphograph {

Eigen::MatrixXf MarkerTracks(const MotionBase& base, const std::vector<Placement>& markers) {
  const std::vector<int> joints = JointsOf(markers, base.skeleton());
  Eigen::MatrixXf tracks(3 * static_cast<Eigen::Index>(markers.size()), base.frame_count());
  WorldPose pose;
  for (Eigen::Index f = 0; f < base.frame_count(); ++f) {
    const std::vector<Eigen::Quaterniond> local = base.LocalRotations(base.rotations().col(f).cast<double>());
    ForwardKinematics(base.skeleton(), local.data(), Eigen::Vector3d(0, base.travel()(3, f), 0), &pose);
    for (std::size_t m = 0; m < markers.size(); ++m) {
      const auto joint = static_cast<std::size_t>(joints[m]);
      tracks.col(f).segment<3>(3 * static_cast<Eigen::Index>(m)) =
          (pose.positions.col(joints[m]) + pose.rotations[joint] * markers[m].offset_m).cast<float>();
    }
  }
  return tracks;
}

MarkerFrame::MarkerFrame(const Eigen::Matrix3Xd& usual) : usual_(2, usual.cols()) {
  usual_ << usual.row(0), usual.row(2);
  usual_.colwise() -= usual_.rowwise().mean().eval();
}

Eigen::Vector3d MarkerFrame::Place::Into(const Eigen::Vector3d& point) const {
  const double x = point.x() - x_m, z = point.z() - z_m;
  return {cosine * x - sine * z, point.y(), sine * x + cosine * z};
}

Eigen::Vector3d MarkerFrame::Place::OutOf(const Eigen::Vector3d& point) const {
  return {cosine * point.x() + sine * point.z() + x_m, point.y(), cosine * point.z() - sine * point.x() + z_m};
}

double MarkerFrame::Place::heading_rad() const { return std::atan2(sine, cosine); }

MarkerFrame::Place MarkerFrame::Fit(const Eigen::Ref<const Eigen::VectorXd>& points) const {
  Place place;
  const Eigen::Index count = usual_.cols();
  for (Eigen::Index m = 0; m < count; ++m) {
    place.x_m += points[3 * m] / static_cast<double>(count);
    place.z_m += points[3 * m + 2] / static_cast<double>(count);
  }
  // Of all turns by h, sum_m |Yaw(-h) p_m - u_m|^2 is least where (cos h, sin h) is along these two sums.
  double along = 0, across = 0;
  for (Eigen::Index m = 0; m < count; ++m) {
    const double x = points[3 * m] - place.x_m, z = points[3 * m + 2] - place.z_m;
    along += x * usual_(0, m) + z * usual_(1, m);
    across += x * usual_(1, m) - z * usual_(0, m);
  }
  const double length = std::hypot(along, across);
  if (length > 1e-9) {  // else all markers lie above one point, and no turn is better than another
    place.cosine = along / length;
    place.sine = across / length;
  }
  return place;
}

}  // namespace morphograph
