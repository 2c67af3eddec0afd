#include "synthesis/sensors/pose_channels.h"

#include <cmath>

namespace morphograph {
namespace {

constexpr double kLeastReach_m = 0.02;   // leaves turn without moving any joint
constexpr double kTimeOfStep_s = 0.1;
constexpr Eigen::Index kFramesOfMean = 500;

// Root mean square distance, over all measured joints, of those below each joint from it, in usual poses. (joints)
Eigen::VectorXd Reaches(const MotionBase& base) {
  const Skeleton& skeleton = base.skeleton();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(skeleton.joint_count());
  const Eigen::Index stride = std::max<Eigen::Index>(1, base.frame_count() / kFramesOfMean);
  WorldPose pose;
  Eigen::Index frames = 0;
  for (Eigen::Index frame = 0; frame < base.frame_count(); frame += stride, ++frames) {
    base.PelvisPose(base.rotations().col(frame).cast<double>(), &pose);
    for (const int below : base.measured_joints()) {
      for (int joint = skeleton.parent(below); joint >= 0; joint = skeleton.parent(joint))
        sums[joint] += (pose.positions.col(below) - pose.positions.col(joint)).squaredNorm();
    }
  }
  return (sums / static_cast<double>(frames * static_cast<Eigen::Index>(base.measured_joints().size()))).cwiseSqrt();
}

}  // namespace

PoseChannels::PoseChannels(const MotionBase& base) {
  const Eigen::VectorXd reaches = Reaches(base);
  const auto joints = static_cast<Eigen::Index>(base.active_joints().size());
  scales_.resize(3 * joints + 4);
  for (Eigen::Index n = 0; n < joints; ++n)
    scales_.segment<3>(3 * n).setConstant(std::max(kLeastReach_m, reaches[base.active_joints()[static_cast<std::size_t>(n)]]));
  const double steps = kTimeOfStep_s * base.frame_rate_hz();
  scales_.tail<4>() << steps, steps, steps * scales_[0], 1;
}

Eigen::VectorXd PoseChannels::Vector(const BasePose& pose) const {
  Eigen::VectorXd vector(size());
  vector << pose.rotations, pose.step, pose.height_m;
  return vector.cwiseProduct(scales_);
}

BasePose PoseChannels::Pose(const Eigen::VectorXd& vector) const {
  const Eigen::VectorXd channels = vector.cwiseQuotient(scales_);
  BasePose pose;
  pose.rotations = channels.head(size() - 4);
  pose.step = channels.segment<3>(size() - 4);
  pose.height_m = channels[size() - 1];
  return pose;
}

Eigen::MatrixXf PoseChannels::Vectors(const MotionBase& base) const {
  Eigen::MatrixXf vectors(size(), base.frame_count());
  vectors << base.rotations(), base.travel();
  return scales_.cast<float>().asDiagonal() * vectors;
}

}  // namespace morphograph
