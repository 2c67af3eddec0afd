#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "datasets/skeleton.h"

namespace morphograph {

/// Recorded or synthesised motion of one skeleton at a constant frame rate, metres, Y up.
///
/// Rotations are `parent_from_joint`; that of the moving root is `world_from_root`. Joints above
/// the moving root stay at the identity at the origin.
class MotionClip {
 public:
  MotionClip() = default;
  /// All rotations identity, root at the origin.
  MotionClip(std::shared_ptr<const Skeleton> skeleton, double frame_rate_hz, int frames);

  const Skeleton& skeleton() const { return *skeleton_; }
  const std::shared_ptr<const Skeleton>& shared_skeleton() const { return skeleton_; }
  double frame_rate_hz() const { return frame_rate_hz_; }
  int frame_count() const { return frames_; }
  int joint_count() const { return joints_; }
  /// Time from the first to the last frame.
  double duration_s() const { return frames_ > 1 ? (frames_ - 1) / frame_rate_hz_ : 0.0; }

  const Eigen::Quaterniond& rotation(int frame, int joint) const {
    return rotations_[static_cast<size_t>(frame) * joints_ + joint];
  }
  Eigen::Quaterniond& rotation(int frame, int joint) {
    return rotations_[static_cast<size_t>(frame) * joints_ + joint];
  }
  /// All rotations of a frame, `joint_count()` of them.
  const Eigen::Quaterniond* rotations(int frame) const { return &rotation(frame, 0); }

  /// World position of the moving root, one frame a column.
  const Eigen::Matrix3Xd& root_positions() const { return root_positions_; }
  Eigen::Matrix3Xd& root_positions() { return root_positions_; }

  /// Frames [first, first + count).
  MotionClip Slice(int first, int count) const;

  std::string name;   // file stem, for reports
  std::string style;  // empty when the data has none

 private:
  std::shared_ptr<const Skeleton> skeleton_;
  double frame_rate_hz_ = 30;
  int frames_ = 0;
  int joints_ = 0;
  std::vector<Eigen::Quaterniond> rotations_;  // frame-major
  Eigen::Matrix3Xd root_positions_;
};

/// The clip turned by `yaw_rad` about +Y (0 keeps +Z forward, positive turns +Z to +X) about the
/// world origin, then moved by (x, z) on the floor.
MotionClip Moved(const MotionClip& clip, double yaw_rad, double x_m, double z_m);

/// Heading of a frame: the direction (left hip - right hip) x up, as yaw in radians, 0 along +Z, pi/2
/// along +X. Needs hip roles; without them the yaw of the root's own +Z is used.
double HeadingRad(const MotionClip& clip, int frame);

}  // namespace morphograph
