#include "primitives/pose_layout.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/euler.h"
#include "datasets/forward_kinematics.h"
#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

// Leaves move no joint, yet hands and toes must not be forgotten: a radian there counts for two centimetres.
constexpr double kLeafWeight = 0.02;

Eigen::Matrix3Xd PositionsOf(const Skeleton& skeleton, const std::vector<Eigen::Quaterniond>& rotations) {
  WorldPose pose;
  ForwardKinematics(skeleton, rotations.data(), Eigen::Vector3d::Zero(), &pose);
  return pose.positions;
}

bool IsBelow(const Skeleton& skeleton, int joint, int ancestor) {
  for (int j = skeleton.parent(joint); j >= 0; j = skeleton.parent(j)) {
    if (j == ancestor) return true;
  }
  return false;
}

// Axes of the joint's rotation channels; those that it has none for follow.
EulerOrder OrderOf(const Joint& joint) {
  std::vector<int> axes;
  for (const Channel channel : joint.channels) {
    const int axis = static_cast<int>(channel) - static_cast<int>(Channel::kXRotation);
    if (axis >= 0 && std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
  }
  for (const int axis : {2, 0, 1}) {
    if (std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
  }
  return {axes[0], axes[1], axes[2]};
}

}  // namespace

PoseLayout::PoseLayout(std::shared_ptr<const Skeleton> skeleton, std::vector<int> active_joints, RotationForm rotation_form)
    : skeleton_(std::move(skeleton)), active_joints_(std::move(active_joints)), rotation_form_(rotation_form) {
  if (active_joints_.empty() || active_joints_[0] != skeleton_->moving_root()) {
    throw std::invalid_argument("PoseLayout: the first active joint must be the moving root");
  }
  for (const int joint : active_joints_) euler_orders_.push_back(OrderOf(skeleton_->joint(joint)));
  const RoleMap& roles = skeleton_->roles();
  if (roles.Has(JointRole::kLeftHip) && roles.Has(JointRole::kRightHip)) {
    const std::vector<Eigen::Quaterniond> rest_rotations(skeleton_->joint_count(), Eigen::Quaterniond::Identity());
    const Eigen::Matrix3Xd rest = PositionsOf(*skeleton_, rest_rotations);
    across_ = rest.col(roles[JointRole::kLeftHip]) - rest.col(roles[JointRole::kRightHip]);
  }
}

Eigen::VectorXd PoseLayout::ChannelWeights(const std::vector<Eigen::Quaterniond>& typical) const {
  const Eigen::Matrix3Xd positions = PositionsOf(*skeleton_, typical);
  const auto& measured = EvaluationRoles();
  Eigen::VectorXd weights(channels());
  weights.head<3>().setConstant(std::sqrt(static_cast<double>(measured.size())));
  for (size_t i = 0; i < active_joints_.size(); ++i) {
    double sum = 0;  // squared distance over the measured joints that this one carries
    for (const JointRole role : measured) {
      const int joint = skeleton_->roles()[role];
      if (joint >= 0 && IsBelow(*skeleton_, joint, active_joints_[i])) {
        sum += (positions.col(joint) - positions.col(active_joints_[i])).squaredNorm();
      }
    }
    // Two of three rotation axes move a point at a distance: hence two thirds.
    weights.segment<3>(3 + 3 * i).setConstant(std::max(kLeafWeight, std::sqrt(2.0 / 3.0 * sum)));
  }
  return weights;
}

Eigen::Vector3d PoseLayout::ChannelsOf(size_t n, const Eigen::Quaterniond& mean, const Eigen::Quaterniond& rotation,
                                       const Eigen::Vector3d& previous) const {
  return rotation_form_ == RotationForm::kEuler ? EulerNear(rotation, euler_orders_[n], previous) : LogMapAbout(mean, rotation);
}

Eigen::Quaterniond PoseLayout::RotationOf(size_t n, const Eigen::Quaterniond& mean, const Eigen::Vector3d& channels) const {
  return rotation_form_ == RotationForm::kEuler ? QuaternionFromEuler(channels, euler_orders_[n]) : ExpMapAbout(mean, channels);
}

double PoseLayout::HeadingOf(const Eigen::Quaterniond& world_from_root) const {
  const Eigen::Vector3d across = world_from_root * across_;
  // across x up
  return std::atan2(-across.z(), across.x());
}

}  // namespace morphograph
