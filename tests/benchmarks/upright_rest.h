#pragma once

#include <Eigen/SVD>
#include <memory>
#include <utility>
#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"
#include "datasets/motion_clip.h"

namespace morphograph {

/// Axes for every joint in which a body's usual pose is the one of no rotation: a column a joint, (world_from_joint in that pose). Usual is the mean over the clips, heading taken out; of
/// ankles and toes, over the frames in which they lie flat. Skeletons whose bones lie along one axis at rest can so be retargeted, which asks for a rest pose that stands.
inline std::vector<Eigen::Quaterniond> UsualPose(const std::vector<MotionClip>& clips) {
  const Skeleton& skeleton = clips.front().skeleton();
  const RoleMap& roles = skeleton.roles();
  std::vector<Eigen::Matrix3d> sums(static_cast<std::size_t>(skeleton.joint_count()), Eigen::Matrix3d::Zero());
  for (const MotionClip& clip : clips) {
    const ContactTrack contacts = DetectContacts(clip);
    for (int f = 0; f < clip.frame_count(); ++f) {
      const WorldPose pose = ForwardKinematics(clip, f);
      const Eigen::Matrix3d level = Eigen::AngleAxisd(-HeadingRad(clip, f), Eigen::Vector3d::UnitY()).toRotationMatrix();
      for (int j = 0; j < skeleton.joint_count(); ++j) {
        const bool left = j == roles[JointRole::kLeftAnkle] || j == roles[JointRole::kLeftToe], right = j == roles[JointRole::kRightAnkle] || j == roles[JointRole::kRightToe];
        const int row = left ? 0 : 2;
        if ((left || right) && !(contacts.planted(row, f) && contacts.planted(row + 1, f))) continue;
        sums[static_cast<std::size_t>(j)] += level * pose.rotations[static_cast<std::size_t>(j)].toRotationMatrix();
      }
    }
  }
  std::vector<Eigen::Quaterniond> usual;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sums[static_cast<std::size_t>(j)], Eigen::ComputeFullU | Eigen::ComputeFullV);
    usual.emplace_back(skeleton.IsBody(j) ? Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())) : Eigen::Quaterniond::Identity());
  }
  return usual;
}

/// The same motion with joints' axes turned so that `usual` is the pose of no rotation.
inline MotionClip WithRestPose(const MotionClip& clip, const std::vector<Eigen::Quaterniond>& usual) {
  const Skeleton& skeleton = clip.skeleton();
  const auto above = [&](int joint) { return skeleton.parent(joint) < 0 ? Eigen::Quaterniond::Identity() : usual[static_cast<std::size_t>(skeleton.parent(joint))]; };
  std::vector<Joint> joints = skeleton.joints();
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    Joint& joint = joints[static_cast<std::size_t>(j)];
    joint.offset_m = above(j) * joint.offset_m;
    if (joint.end_site_m) *joint.end_site_m = usual[static_cast<std::size_t>(j)] * *joint.end_site_m;
  }
  const auto standing = std::make_shared<const Skeleton>(std::move(joints), skeleton.roles(), skeleton.metres_per_unit(), skeleton.up_axis());
  MotionClip turned(standing, clip.frame_rate_hz(), clip.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < skeleton.joint_count(); ++j) turned.rotation(f, j) = (above(j) * clip.rotation(f, j) * usual[static_cast<std::size_t>(j)].conjugate()).normalized();
  }
  turned.root_positions() = clip.root_positions();
  turned.name = clip.name;
  turned.style = clip.style;
  return turned;
}

}  // namespace morphograph
