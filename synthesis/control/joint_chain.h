#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "primitives/pose_layout.h"

namespace morphograph {

/// A joint of a pose, in the frame in which the pose is given, with derivatives by the pose's channels.
struct JointState {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // frame_from_joint
  Eigen::Matrix3Xd position_by_pose;  // (3 x channels)
  /// Turning of the joint about the frame's axes: a small change d of the channels makes rotation exp(turn_by_pose d) rotation.
  Eigen::Matrix3Xd turn_by_pose;      // (3 x channels)
};

/// Forward kinematics of one joint over the channels of a pose (log maps about a style's means), with exact derivatives.
class JointChain {
 public:
  /// @param joint  of the body: the moving root or below it. @throws std::invalid_argument for others, and for other forms of rotation.
  JointChain(const PoseLayout& layout, const MeanRotations& means, int joint);

  /// @param pose  (channels), see PoseLayout.
  JointState At(const Eigen::VectorXd& pose) const;

 private:
  struct Link {
    Eigen::Vector3d offset_m;   // from the parent; nothing for the moving root
    Eigen::Quaterniond mean;
    int active = -1;            // of the layout's active joints; -1: the joint keeps its mean
  };
  std::vector<Link> links_;  // from the moving root to the joint
  int channels_ = 0;
};

}  // namespace morphograph
