#include "datasets/motion_clip.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/forward_kinematics.h"

namespace morphograph {

MotionClip::MotionClip(std::shared_ptr<const Skeleton> skeleton, double frame_rate_hz, int frames)
    : skeleton_(std::move(skeleton)),
      frame_rate_hz_(frame_rate_hz),
      frames_(frames),
      joints_(skeleton_ ? skeleton_->joint_count() : 0) {
  if (!skeleton_) throw std::invalid_argument("MotionClip: no skeleton");
  if (!(frame_rate_hz > 0 && std::isfinite(frame_rate_hz))) {
    throw std::invalid_argument("MotionClip: frame rate must be positive");
  }
  if (frames < 0) throw std::invalid_argument("MotionClip: negative frame count");
  rotations_.assign(static_cast<size_t>(frames) * joints_, Eigen::Quaterniond::Identity());
  root_positions_ = Eigen::Matrix3Xd::Zero(3, frames);
}

MotionClip MotionClip::Slice(int first, int count) const {
  if (first < 0 || count < 0 || first > frames_ || count > frames_ - first) {
    throw std::invalid_argument("MotionClip::Slice: frames " + std::to_string(first) + " + " + std::to_string(count) +
                                " of " + std::to_string(frames_));
  }
  MotionClip slice(skeleton_, frame_rate_hz_, count);
  std::copy_n(rotations_.begin() + static_cast<std::ptrdiff_t>(first) * joints_,
              static_cast<std::ptrdiff_t>(count) * joints_, slice.rotations_.begin());
  slice.root_positions_ = root_positions_.middleCols(first, count);
  slice.name = name;
  slice.style = style;
  return slice;
}

MotionClip Moved(const MotionClip& clip, double yaw_rad, double x_m, double z_m) {
  MotionClip moved = clip;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()));
  const int root = clip.skeleton().moving_root();
  for (int f = 0; f < clip.frame_count(); ++f) {
    moved.rotation(f, root) = turn * clip.rotation(f, root);
    moved.root_positions().col(f) = turn * clip.root_positions().col(f) + Eigen::Vector3d(x_m, 0, z_m);
  }
  return moved;
}

double HeadingRad(const MotionClip& clip, int frame) {
  const RoleMap& roles = clip.skeleton().roles();
  const int root = clip.skeleton().moving_root();
  Eigen::Vector3d forward = clip.rotation(frame, root) * Eigen::Vector3d::UnitZ();
  if (roles.Has(JointRole::kLeftHip) && roles.Has(JointRole::kRightHip)) {
    const WorldPose pose = ForwardKinematics(clip, frame);
    const Eigen::Vector3d across =
        pose.positions.col(roles[JointRole::kLeftHip]) - pose.positions.col(roles[JointRole::kRightHip]);
    forward = across.cross(Eigen::Vector3d::UnitY());
  }
  return std::atan2(forward.x(), forward.z());
}

}  // namespace morphograph
