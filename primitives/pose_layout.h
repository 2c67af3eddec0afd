#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/skeleton.h"

namespace morphograph {

/// Samples of a step on its canonical timeline: phase 0 is the first key frame, 1 the second, and a margin of a quarter step lies
/// on both sides, shared with the neighbours (METHODS section 3).
inline constexpr int kPhaseSamples = 25;
inline constexpr double kPhaseMargin = 0.25;
inline constexpr double kPhaseSpacing = (1 + 2 * kPhaseMargin) / (kPhaseSamples - 1);
inline double PhaseOfSample(int sample) { return -kPhaseMargin + sample * kPhaseSpacing; }

/// What three channels say a rotation.
enum class RotationForm {
  kLogMap,  // rotation vector about the style's mean rotation of the joint
  kEuler,   // angles in the order of the recording's channels (Du Eq. 3.8), which wrap and lock; to compare with
};

/// Which channels describe a pose, and what each weighs.
///
/// A pose is a column: root position (x, y, z), then a log-map vector of the root and of every active joint about the style's
/// mean rotation of that joint (or Euler angles, see RotationForm). Joints that never move are not modelled; they keep their mean.
class PoseLayout {
 public:
  PoseLayout() = default;
  /// @param active_joints  modelled joints, the moving root first, then in hierarchy order.
  /// @throws std::invalid_argument when the first is not the moving root.
  PoseLayout(std::shared_ptr<const Skeleton> skeleton, std::vector<int> active_joints,
             RotationForm rotation_form = RotationForm::kLogMap);

  const Skeleton& skeleton() const { return *skeleton_; }
  const std::shared_ptr<const Skeleton>& shared_skeleton() const { return skeleton_; }
  const std::vector<int>& active_joints() const { return active_joints_; }
  RotationForm rotation_form() const { return rotation_form_; }
  int channels() const { return 3 + 3 * static_cast<int>(active_joints_.size()); }

  /// Weight of every pose channel: a metre of root motion counts for all joints, a radian of a joint for the
  /// distance that it moves the joints below it. (channels), to be applied to values before squaring.
  ///
  /// @param typical  a usual pose of the body, to measure distances in (its joints' local rotations).
  Eigen::VectorXd ChannelWeights(const std::vector<Eigen::Quaterniond>& typical) const;

  /// The three channels of a rotation. Angles are the ones nearest to `previous`, so that they run on along a motion.
  /// @param n  which of the active joints. @param mean  of that joint and style; Euler angles need none.
  Eigen::Vector3d ChannelsOf(size_t n, const Eigen::Quaterniond& mean, const Eigen::Quaterniond& rotation,
                             const Eigen::Vector3d& previous) const;
  /// Inverse of ChannelsOf.
  Eigen::Quaterniond RotationOf(size_t n, const Eigen::Quaterniond& mean, const Eigen::Vector3d& channels) const;

  /// Heading (yaw, radians) of a world rotation of the moving root: across the hips, turned to forward.
  double HeadingOf(const Eigen::Quaterniond& world_from_root) const;
  /// Right hip to left hip, in the root's frame: what headings are read from.
  const Eigen::Vector3d& across_hips() const { return across_; }

 private:
  std::shared_ptr<const Skeleton> skeleton_;
  std::vector<int> active_joints_;
  RotationForm rotation_form_ = RotationForm::kLogMap;
  std::vector<std::array<int, 3>> euler_orders_;           // of the active joints; axes 0 = X, 1 = Y, 2 = Z
  Eigen::Vector3d across_ = Eigen::Vector3d::UnitX();  // right hip to left hip, in the root's frame
};

/// Mean rotation of every joint of one style, log maps are taken about it. The root's is in the step's own frame.
using MeanRotations = std::vector<Eigen::Quaterniond>;  // joint_count()

inline Eigen::Quaterniond Yaw(double yaw_rad) {
  return Eigen::Quaterniond(std::cos(yaw_rad / 2), 0, std::sin(yaw_rad / 2), 0);
}

}  // namespace morphograph
