#include "datasets/forward_kinematics.h"

namespace morphograph {

void ForwardKinematics(const Skeleton& skeleton, const Eigen::Quaterniond* rotations,
                       const Eigen::Vector3d& root_position, WorldPose* pose) {
  const int joints = skeleton.joint_count();
  pose->positions.resize(3, joints);
  pose->rotations.resize(joints);
  for (int j = 0; j < joints; ++j) {
    const int parent = skeleton.parent(j);
    if (j == skeleton.moving_root()) {
      pose->rotations[j] = rotations[j];
      pose->positions.col(j) = root_position;
    } else if (parent < 0) {
      pose->rotations[j] = Eigen::Quaterniond::Identity();
      pose->positions.col(j).setZero();
    } else {
      pose->rotations[j] = pose->rotations[parent] * rotations[j];
      pose->positions.col(j) = pose->positions.col(parent) + pose->rotations[parent] * skeleton.joint(j).offset_m;
    }
  }
}

WorldPose ForwardKinematics(const MotionClip& clip, int frame) {
  WorldPose pose;
  ForwardKinematics(clip.skeleton(), clip.rotations(frame), clip.root_positions().col(frame), &pose);
  return pose;
}

std::vector<WorldPose> WorldPoses(const MotionClip& clip) {
  std::vector<WorldPose> poses(clip.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &poses[f]);
  }
  return poses;
}

std::vector<Eigen::Matrix3Xd> JointPositions(const MotionClip& clip) {
  std::vector<Eigen::Matrix3Xd> positions(clip.frame_count());
  WorldPose pose;
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    positions[f] = pose.positions;
  }
  return positions;
}

}  // namespace morphograph
