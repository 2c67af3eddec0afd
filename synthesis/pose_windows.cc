#include "synthesis/pose_windows.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace morphograph {

Eigen::MatrixXd PoseFeatures(const EvaluationMotion& motion) {
  const RoleMap& roles = motion.skeleton->roles();
  if (const std::vector<std::string> missing = roles.Missing(EvaluationRoles()); !missing.empty()) {
    throw std::invalid_argument("PoseFeatures: the skeleton has no joint for role '" + missing.front() + "'");
  }
  const int frames = motion.frame_count();
  if (frames < 2) throw std::invalid_argument("PoseFeatures: at least 2 frames are needed");
  const int hips = roles[JointRole::kHips];
  const int left = roles[JointRole::kLeftHip], right = roles[JointRole::kRightHip];
  const int joints = static_cast<int>(EvaluationRoles().size());

  Eigen::MatrixXd features(3 * joints + 2, frames);
  for (int f = 0; f < frames; ++f) {
    const Eigen::Matrix3Xd& positions = motion.joint_positions[static_cast<size_t>(f)];
    // Heading: (left hip - right hip) x up, so (x, z) of the forward axis is (-across.z, across.x).
    const Eigen::Vector3d across = positions.col(left) - positions.col(right);
    Eigen::Vector2d forward(-across.z(), across.x());
    forward = forward.norm() > 1e-9 ? Eigen::Vector2d(forward.normalized()) : Eigen::Vector2d(0, 1);
    const Eigen::Vector2d leftward(forward.y(), -forward.x());

    const Eigen::Vector3d root = positions.col(hips);
    for (int i = 0; i < joints; ++i) {
      const Eigen::Vector3d point = positions.col(roles[EvaluationRoles()[static_cast<size_t>(i)]]);
      const Eigen::Vector2d planar(point.x() - root.x(), point.z() - root.z());
      features(3 * i, f) = planar.dot(leftward);
      features(3 * i + 1, f) = point.y() - motion.ground.HeightAt(root);
      features(3 * i + 2, f) = planar.dot(forward);
    }
    const int before = std::max(f - 1, 0), after = std::min(f + 1, frames - 1);
    const Eigen::Vector3d moved = motion.joint_positions[static_cast<size_t>(after)].col(hips) -
                                  motion.joint_positions[static_cast<size_t>(before)].col(hips);
    const Eigen::Vector2d velocity =
        Eigen::Vector2d(moved.x(), moved.z()) * kEvaluationRateHz / (after - before);
    features(3 * joints, f) = velocity.dot(leftward);
    features(3 * joints + 1, f) = velocity.dot(forward);
  }
  return features;
}

Eigen::MatrixXd PoseWindows(const EvaluationMotion& motion, const PoseWindowOptions& options) {
  if (options.frames < 1 || options.stride < 1 || options.hop < 1) {
    throw std::invalid_argument("PoseWindows: frames, stride and hop must be positive");
  }
  const Eigen::MatrixXd features = PoseFeatures(motion);
  const int rows = static_cast<int>(features.rows());
  const int kept = (options.frames + options.stride - 1) / options.stride;
  const int spare = static_cast<int>(features.cols()) - options.frames;
  const int count = spare < 0 ? 0 : spare / options.hop + 1;
  Eigen::MatrixXd windows(rows * kept, count);
  for (int w = 0; w < count; ++w) {
    for (int k = 0; k < kept; ++k) {
      windows.col(w).segment(rows * k, rows) = features.col(w * options.hop + k * options.stride);
    }
  }
  return windows;
}

Eigen::MatrixXd JoinColumns(const std::vector<Eigen::MatrixXd>& parts) {
  if (parts.empty()) throw std::invalid_argument("JoinColumns: nothing given");
  Eigen::Index columns = 0;
  for (const Eigen::MatrixXd& part : parts) {
    if (part.rows() != parts.front().rows()) throw std::invalid_argument("JoinColumns: heights differ");
    columns += part.cols();
  }
  Eigen::MatrixXd joined(parts.front().rows(), columns);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& part : parts) {
    joined.middleCols(at, part.cols()) = part;
    at += part.cols();
  }
  return joined;
}

}  // namespace morphograph
