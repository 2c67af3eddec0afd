#include "synthesis/control/pose_layer.h"

#include <gtest/gtest.h>

#include <boost/random/normal_distribution.hpp>
#include <filesystem>
#include <random>

#include "graph/model_io.h"
#include "primitives/rotation_math.h"
#include "synthesis/control/arm_range.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

const MotionClip& Walk() {
  static const MotionClip clip = [] {
    SynthesisRequest request;
    request.seed = 3;  // whose arms reach the points below without the trunk
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

ArmRange RangeOfArm(bool left, int frame) {
  return ArmRange(Walk().skeleton(), ForwardKinematics(Walk(), frame), Joint(left ? JointRole::kLeftShoulder : JointRole::kRightShoulder),
                  Joint(left ? JointRole::kLeftElbow : JointRole::kRightElbow), Joint(left ? JointRole::kLeftWrist : JointRole::kRightWrist));
}

// A point behind the back, at the height of the shoulders: no arm folds that way, however the trunk leans.
TEST(PoseLayer, DoesNotFoldAnArmBehindTheBack) {
  for (const bool left : {true, false}) {
    MotionClip clip = Walk();
    const int frame = 60, shoulder = Joint(left ? JointRole::kLeftShoulder : JointRole::kRightShoulder), wrist = Joint(left ? JointRole::kLeftWrist : JointRole::kRightWrist);
    const WorldPose before = ForwardKinematics(clip, frame);
    const double heading = HeadingRad(clip, frame);
    Eigen::Vector3d target = clip.root_positions().col(frame) - 0.3 * Eigen::Vector3d(std::sin(heading), 0, std::cos(heading));
    target.y() = before.positions(1, shoulder);
    ASSERT_LT((target - before.positions.col(shoulder)).norm(), 0.45) << "near enough for an arm that could be turned any way";
    ApplyPoseGoal({wrist, frame, frame, [&](int, const WorldPose&) { return target; }, nullptr}, Walk(), &clip);
    EXPECT_GT((ForwardKinematics(clip, frame).positions.col(wrist) - target).norm(), 0.03);
    for (int f = 0; f < clip.frame_count(); ++f) EXPECT_LT(RangeOfArm(left, f).Excess(ForwardKinematics(clip, f)), 0.01) << "frame " << f;
  }
}

TEST(PoseLayer, LeansForAPointThatTheArmAloneMisses) {
  const int wrist = Joint(JointRole::kLeftWrist), shoulder = Joint(JointRole::kLeftShoulder), elbow = Joint(JointRole::kLeftElbow), frame = 60;
  const WorldPose before = ForwardKinematics(Walk(), frame);
  const double reach = (before.positions.col(elbow) - before.positions.col(shoulder)).norm() + (before.positions.col(wrist) - before.positions.col(elbow)).norm();
  const double heading = HeadingRad(Walk(), frame);
  const Eigen::Vector3d ahead = (Eigen::Vector3d(std::sin(heading), 0, std::cos(heading)) - Eigen::Vector3d(0, 0.4, 0)).normalized();
  const Eigen::Vector3d target = before.positions.col(shoulder) + (reach + 0.09) * ahead;
  MotionClip clip = Walk();
  ApplyPoseGoal({wrist, frame, frame, [&](int, const WorldPose&) { return target; }, nullptr}, Walk(), &clip);
  const WorldPose pose = ForwardKinematics(clip, frame);
  EXPECT_LT((pose.positions.col(wrist) - target).norm(), 0.005);
  const auto neck = static_cast<size_t>(clip.skeleton().parent(Joint(JointRole::kHead)));
  const double lean = pose.rotations[neck].angularDistance(before.rotations[neck]);
  EXPECT_GT(lean, 0.01);
  EXPECT_LT(lean, 0.27);
  for (const JointRole role : {JointRole::kHips, JointRole::kLeftToe, JointRole::kRightToe}) EXPECT_EQ(pose.positions.col(Joint(role)), before.positions.col(Joint(role)));
}

// Any way that an upper arm is turned, it is brought back into its range, and both sides have the same one.
TEST(ArmRange, BringsBackAndKnowsNoSides) {
  const int frame = 60;
  const WorldPose walk = ForwardKinematics(Walk(), frame);
  std::mt19937_64 rng(3);
  boost::random::normal_distribution<double> normal;
  const Eigen::Vector3d left_shoulder = walk.positions.col(Joint(JointRole::kLeftShoulder)), right_shoulder = walk.positions.col(Joint(JointRole::kRightShoulder));
  const Eigen::Vector3d up = ((left_shoulder + right_shoulder) - walk.positions.col(Joint(JointRole::kLeftHip)) - walk.positions.col(Joint(JointRole::kRightHip))).normalized();
  const Eigen::Vector3d to_left = (left_shoulder - right_shoulder - up * up.dot(left_shoulder - right_shoulder)).normalized();
  int outside = 0;
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector3d upper(normal(rng), normal(rng), normal(rng)), lower(normal(rng), normal(rng), normal(rng));
    double excess[2];
    for (const bool left : {true, false}) {
      const ArmRange range = RangeOfArm(left, frame);
      WorldPose pose = walk;
      const int shoulder = Joint(left ? JointRole::kLeftShoulder : JointRole::kRightShoulder), elbow = Joint(left ? JointRole::kLeftElbow : JointRole::kRightElbow),
                wrist = Joint(left ? JointRole::kLeftWrist : JointRole::kRightWrist);
      const auto mirrored = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return left ? v : Eigen::Vector3d(v - 2 * to_left * to_left.dot(v)); };
      pose.positions.col(elbow) = pose.positions.col(shoulder) + mirrored(upper);
      pose.positions.col(wrist) = pose.positions.col(elbow) + mirrored(lower);
      excess[left] = range.Excess(pose);
      const auto back = range.Back(pose);
      EXPECT_EQ(back.has_value(), excess[left] > 1e-4);
      if (!back) continue;
      ++outside;
      pose.positions.col(elbow) = pose.positions.col(shoulder) + *back * mirrored(upper);
      pose.positions.col(wrist) = pose.positions.col(elbow) + *back * mirrored(lower);
      EXPECT_LT(range.Excess(pose), 0.01);
    }
    EXPECT_NEAR(excess[0], excess[1], 1e-6);
  }
  EXPECT_GT(outside, 100);
  EXPECT_LT(outside, 300);
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
