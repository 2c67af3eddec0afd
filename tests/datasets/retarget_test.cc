#include "datasets/retarget.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"
#include "datasets/quantile.h"
#include "datasets/synthetic_skeleton.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

MotionClip Read(const char* file) { return ImportClip(ReadBvhFile(testing::SharedData() / file)); }

constexpr const char* kXsens = "real_imu/neura_s02/S02-Trial-Walk-1_xsens.bvh";

// Direction of a bone in the world.
Eigen::Vector3d Bone(const MotionClip& clip, int frame, JointRole from, JointRole to) {
  const WorldPose pose = ForwardKinematics(clip, frame);
  const RoleMap& roles = clip.skeleton().roles();
  return (pose.positions.col(roles[to]) - pose.positions.col(roles[from])).normalized();
}

// Mean speed of the balls of the feet while they stand, m/s.
double Skate(const MotionClip& clip, const ContactTrack& contacts, int* frames) {
  double sum = 0;
  *frames = 0;
  for (int side = 0; side < 2; ++side) {
    const int toe = clip.skeleton().roles()[side == 0 ? JointRole::kLeftToe : JointRole::kRightToe];
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    for (int f = 0; f < clip.frame_count(); ++f) {
      const Eigen::Vector3d ball = ForwardKinematics(clip, f).positions.col(toe);
      if (f > 0 && contacts.planted(2 * side + 1, f) && contacts.planted(2 * side + 1, f - 1)) {
        sum += (ball - before).norm() * clip.frame_rate_hz();
        ++*frames;
      }
      before = ball;
    }
  }
  return sum / std::max(1, *frames);
}

TEST(Retarget, ToItsOwnSkeletonChangesNothing) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  for (const char* file : {"cmu/07/07_01.bvh", "bnr/dataset-2/run/dataset-2_run_normal_001.bvh"}) {
    const MotionClip clip = Read(file);
    const MotionClip same = Retarget(clip, clip.shared_skeleton());
    EXPECT_LT((same.root_positions() - clip.root_positions()).norm(), 1e-12);
    EXPECT_EQ(same.rotation(7, 9).coeffs(), clip.rotation(7, 9).coeffs());
  }
}

TEST(Retarget, SubjectsOfOneDataSetExchangeLocalRotations) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip seven = Read("cmu/07/07_01.bvh"), eight = Read("cmu/08/08_01.bvh"), other = Read("cmu/131/131_01.bvh");
  EXPECT_TRUE(SameRestPose(seven.skeleton(), eight.skeleton()));
  EXPECT_FALSE(SameRestPose(seven.skeleton(), other.skeleton()));
  EXPECT_FALSE(SameBones(seven.skeleton(), eight.skeleton()));
  EXPECT_TRUE(SameBones(seven.skeleton(), Read("cmu/07/07_02.bvh").skeleton()));
  const MotionClip moved = Retarget(seven, eight.shared_skeleton());
  const RoleMap& roles = seven.skeleton().roles();
  for (const JointRole role : {JointRole::kHips, JointRole::kChest, JointRole::kHead, JointRole::kLeftShoulder, JointRole::kRightElbow, JointRole::kRightWrist}) {
    EXPECT_EQ(moved.rotation(20, roles[role]).coeffs(), seven.rotation(20, roles[role]).coeffs());
  }
}

// The legs of 08 are 1.5 and 0.6 % shorter than those of 07, left and right: their turns alone leave the feet apart by 2 cm in height.
// bnr's files begin where the take began, so their roots have offsets of their own.
TEST(Retarget, WhereTheRootStartsIsNoBone) {
  const auto skeleton = SyntheticSkeleton();
  std::vector<Joint> joints = skeleton->joints();
  joints[static_cast<std::size_t>(skeleton->moving_root())].offset_m += Eigen::Vector3d(1, 0, 2);
  const auto rebuilt = [&] { return Skeleton(joints, skeleton->roles(), skeleton->metres_per_unit(), skeleton->up_axis()); };
  EXPECT_TRUE(SameBones(*skeleton, rebuilt()));
  joints[static_cast<std::size_t>(skeleton->roles()[JointRole::kLeftKnee])].offset_m *= 1.001;
  EXPECT_FALSE(SameBones(*skeleton, rebuilt()));
}

TEST(Retarget, FeetOfUnequalLegsGoWhereTheSourceWent) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip seven = Read("cmu/07/07_01.bvh");
  for (const char* file : {"cmu/08/08_02.bvh", "cmu/08/08_08.bvh", "cmu/131/131_01.bvh"}) {
    const MotionClip clip = Read(file), moved = Retarget(clip, seven.shared_skeleton());
    const double scale = moved.skeleton().leg_length_m() / clip.skeleton().leg_length_m();
    const auto at = [](const MotionClip& of, int f, JointRole role) -> Eigen::Vector3d { return ForwardKinematics(of, f).positions.col(of.skeleton().roles()[role]); };
    const auto low = [&](const MotionClip& of, JointRole ball) {
      std::vector<double> heights;
      for (int f = 0; f < of.frame_count(); ++f) heights.push_back(at(of, f, ball).y());
      return Quantile(heights, 0.1);
    };
    const double level = 0.5 * (low(clip, JointRole::kLeftToe) + low(clip, JointRole::kRightToe));
    for (const bool left : {true, false}) {
      const JointRole ankle = left ? JointRole::kLeftAnkle : JointRole::kRightAnkle, ball = left ? JointRole::kLeftToe : JointRole::kRightToe;
      std::vector<double> heights, aside;
      const double of_ball = low(clip, ball);
      for (int f = 0; f < clip.frame_count(); ++f) {
        const Eigen::Vector3d away = at(moved, f, ankle) - scale * at(clip, f, ankle);
        aside.push_back(std::hypot(away.x(), away.z()));
        heights.push_back(std::abs(at(moved, f, ball).y() - level - scale * (at(clip, f, ball).y() - of_ball)));
      }
      // Where a leg is as good as straight it falls short a little.
      EXPECT_LT(Quantile(aside, 0.95), 0.01) << file << left;
      EXPECT_LT(Quantile(heights, 0.8), 0.002) << file << left;
      EXPECT_LT(Quantile(heights, 1), 0.015) << file << left;
      RecordProperty(std::string(file) + (left ? "_left" : "_right"), std::to_string(Quantile(aside, 0.95)) + " " + std::to_string(Quantile(heights, 0.8)) + " " + std::to_string(Quantile(heights, 1)));
    }
  }
}

TEST(Retarget, BonesPointWhereTheSourceBonesPoint) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip seven = Read("cmu/07/07_01.bvh");
  const std::vector<std::shared_ptr<const Skeleton>> targets = {seven.shared_skeleton(), SyntheticSkeleton(1.6)};
  for (const char* file : {"cmu/131/131_01.bvh", kXsens, "cmu/08/08_05.bvh"}) {
    const MotionClip clip = Read(file);
    for (const auto& target : targets) {
      if (SameRestPose(clip.skeleton(), *target)) continue;
      const MotionClip moved = Retarget(clip, target);
      for (int f = 0; f < clip.frame_count(); f += 97) {
        for (const auto& [from, to] :
             {std::pair{JointRole::kLeftShoulder, JointRole::kLeftElbow}, {JointRole::kRightElbow, JointRole::kRightWrist}}) {
          EXPECT_GT(Bone(clip, f, from, to).dot(Bone(moved, f, from, to)), 1 - 1e-9) << file << " " << f;
        }
        // Legs give way a little, as their feet have a place to go to.
        for (const auto& [from, to] : {std::pair{JointRole::kLeftHip, JointRole::kLeftKnee}, {JointRole::kRightKnee, JointRole::kRightAnkle}}) {
          EXPECT_GT(Bone(clip, f, from, to).dot(Bone(moved, f, from, to)), std::cos(0.3)) << file << " " << f;
        }
        EXPECT_NEAR(std::remainder(HeadingRad(clip, f) - HeadingRad(moved, f), 6.283185307179586), 0, 0.05) << file << " " << f;
      }
    }
  }
}

TEST(Retarget, FeetStandAsTheyStoodInTheSource) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip seven = Read("cmu/07/07_01.bvh");
  for (const char* file : {"cmu/131/131_01.bvh", kXsens}) {
    const MotionClip clip = Read(file);
    const MotionClip moved = Retarget(clip, seven.shared_skeleton());
    const ContactTrack before = DetectContacts(clip);
    int frames = 0;
    const double skate_before = Skate(clip, before, &frames);
    ASSERT_GT(frames, 100) << file;
    const double skate_after = Skate(moved, before, &frames);
    RecordProperty(std::string(file == kXsens ? "xsens" : "cmu131") + "_skate_cm_s",
                   std::to_string(100 * skate_before) + " to " + std::to_string(100 * skate_after));
    EXPECT_LT(skate_after, skate_before + 0.05) << file;
    // As many steps as before.
    EXPECT_NEAR(static_cast<double>(DetectContacts(moved).intervals.size()),
                static_cast<double>(before.intervals.size()), 1.0) << file;
  }
}

TEST(Retarget, RefusesRestPosesThatDoNotStand) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip seven = Read("cmu/07/07_01.bvh");
  const MotionClip bnr = Read("bnr/dataset-2/run/dataset-2_run_normal_001.bvh");
  EXPECT_THROW(Retarget(seven, bnr.shared_skeleton()), std::invalid_argument);
  EXPECT_THROW(Retarget(bnr, seven.shared_skeleton()), std::invalid_argument);
  EXPECT_THROW(Retarget(seven, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
