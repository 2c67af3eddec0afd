#include "synthesis/control/pose_layer.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "graph/model_io.h"
#include "primitives/rotation_math.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

const MotionClip& Walk() {
  static const MotionClip clip = [] {
    SynthesisRequest request;
    request.duration_s = 4;
    return Synthesize(*LoadModel(std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / "datasets/models/walk.mgm"), request).clip;
  }();
  return clip;
}

int Joint(JointRole role) { return Walk().skeleton().roles()[role]; }

double ElbowFlexion(const WorldPose& pose, JointRole shoulder, JointRole elbow, JointRole wrist) {
  const Eigen::Vector3d upper = pose.positions.col(Joint(elbow)) - pose.positions.col(Joint(shoulder));
  const Eigen::Vector3d lower = pose.positions.col(Joint(wrist)) - pose.positions.col(Joint(elbow));
  return std::acos(upper.normalized().dot(lower.normalized()));
}

TEST(PoseLayer, KnowsArmsAndHeadFromTheRest) {
  const Skeleton& skeleton = Walk().skeleton();
  for (const JointRole role : {JointRole::kLeftWrist, JointRole::kRightElbow, JointRole::kHead}) EXPECT_FALSE(LimbChain(skeleton, Joint(role)).empty()) << RoleName(role);
  for (const JointRole role : {JointRole::kHips, JointRole::kLeftToe, JointRole::kRightKnee}) EXPECT_TRUE(LimbChain(skeleton, Joint(role)).empty()) << RoleName(role);
}

TEST(PoseLayer, ReachesAPointAndLeavesTheRestAlone) {
  MotionClip clip = Walk();
  const int wrist = Joint(JointRole::kRightWrist), frame = 60;
  const Eigen::Vector3d target = ForwardKinematics(clip, frame).positions.col(wrist) + Eigen::Vector3d(0.05, 0.25, 0.05);
  ApplyPoseGoal({wrist, frame, frame, [&](int, const WorldPose&) { return target; }, nullptr}, Walk(), &clip);
  EXPECT_LT((ForwardKinematics(clip, frame).positions.col(wrist) - target).norm(), 1e-3);
  EXPECT_EQ(clip.root_positions(), Walk().root_positions());
  double fastest = 0, fastest_before = 0;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose now = ForwardKinematics(clip, f), before = ForwardKinematics(Walk(), f);
    for (const JointRole role : {JointRole::kLeftWrist, JointRole::kHead, JointRole::kLeftToe})
      EXPECT_EQ(now.positions.col(Joint(role)), before.positions.col(Joint(role)));
    if (std::abs(f - frame) > 30) {
      EXPECT_EQ(now.positions.col(wrist), before.positions.col(wrist));
    }
    EXPECT_GT(ElbowFlexion(now, JointRole::kRightShoulder, JointRole::kRightElbow, JointRole::kRightWrist), 0);
    if (f == 0) continue;
    fastest = std::max(fastest, (now.positions.col(wrist) - ForwardKinematics(clip, f - 1).positions.col(wrist)).norm());
    fastest_before = std::max(fastest_before, (before.positions.col(wrist) - ForwardKinematics(Walk(), f - 1).positions.col(wrist)).norm());
  }
  EXPECT_LT(fastest, fastest_before + 0.1) << "no jump: at most 3 m/s more at 30 fps";
}

TEST(PoseLayer, DoesWhatItCanForAPointOutOfReach) {
  MotionClip clip = Walk();
  const int wrist = Joint(JointRole::kLeftWrist), shoulder = Joint(JointRole::kLeftShoulder), frame = 60;
  const Eigen::Vector3d target = ForwardKinematics(clip, frame).positions.col(shoulder) + Eigen::Vector3d(0, -0.3, 3);
  ApplyPoseGoal({wrist, frame, frame, [&](int, const WorldPose&) { return target; }, nullptr}, Walk(), &clip);
  const WorldPose pose = ForwardKinematics(clip, frame);
  EXPECT_LT((pose.positions.col(wrist) - target).norm(), (ForwardKinematics(Walk(), frame).positions.col(wrist) - target).norm() - 0.1);
  EXPECT_GT(ElbowFlexion(pose, JointRole::kLeftShoulder, JointRole::kLeftElbow, JointRole::kLeftWrist), 0.05);
  for (int j = 0; j < clip.joint_count(); ++j) EXPECT_TRUE(clip.rotation(frame, j).coeffs().allFinite());
}

TEST(PoseLayer, TurnsTheHeadForASpan) {
  MotionClip clip = Walk();
  const int head = Joint(JointRole::kHead);
  const Eigen::Quaterniond wanted = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()) * ForwardKinematics(clip, 45).rotations[static_cast<size_t>(head)];
  ApplyPoseGoal({head, 40, 60, nullptr, [&](int, const WorldPose& pose) { return LogMap(wanted * pose.rotations[static_cast<size_t>(head)].conjugate()); }}, Walk(), &clip);
  for (int f = 40; f <= 60; ++f) EXPECT_LT(ForwardKinematics(clip, f).rotations[static_cast<size_t>(head)].angularDistance(wanted), 0.01);
}

}  // namespace
}  // namespace morphograph
