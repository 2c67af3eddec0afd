#include "synthesis/control/joint_chain.h"

#include <algorithm>
#include <stdexcept>

#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

}  // namespace

JointChain::JointChain(const PoseLayout& layout, const MeanRotations& means, int joint) : channels_(layout.channels()) {
  if (layout.rotation_form() != RotationForm::kLogMap) throw std::invalid_argument("JointChain: only log maps can be steered");
  const Skeleton& skeleton = layout.skeleton();
  const auto& active = layout.active_joints();
  for (int j = joint;; j = skeleton.parent(j)) {
    if (j < 0) throw std::invalid_argument("JointChain: '" + skeleton.joint(joint).name + "' is not a joint of the body");
    const auto found = std::find(active.begin(), active.end(), j);
    links_.push_back({skeleton.joint(j).offset_m, means[static_cast<size_t>(j)], found == active.end() ? -1 : static_cast<int>(found - active.begin())});
    if (j == skeleton.moving_root()) break;
  }
  std::reverse(links_.begin(), links_.end());
}

JointState JointChain::At(const Eigen::VectorXd& pose) const {
  JointState state;
  state.position_by_pose = state.turn_by_pose = Eigen::Matrix3Xd::Zero(3, channels_);
  state.position_m = pose.head<3>();
  state.position_by_pose.leftCols<3>().setIdentity();
  std::vector<Eigen::Vector3d> pivots(links_.size());
  for (size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    if (i > 0) state.position_m += state.rotation * link.offset_m;
    pivots[i] = state.position_m;
    if (link.active < 0) {
      state.rotation = state.rotation * link.mean.toRotationMatrix();
      continue;
    }
    const Eigen::Vector3d turn = pose.segment<3>(3 + 3 * link.active);
    state.rotation = state.rotation * ExpMapAbout(link.mean, turn).toRotationMatrix();
    state.turn_by_pose.middleCols<3>(3 + 3 * link.active) = state.rotation * RightJacobian(turn);
  }
  for (size_t i = 0; i < links_.size(); ++i) {
    if (links_[i].active < 0) continue;
    const auto turn = state.turn_by_pose.middleCols<3>(3 + 3 * links_[i].active);
    state.position_by_pose.middleCols<3>(3 + 3 * links_[i].active) = -Cross(state.position_m - pivots[i]) * turn;
  }
  return state;
}

}  // namespace morphograph
