#include "synthesis/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "datasets/dataset_loader.h"
#include "synthesis/body_check.h"
#include "tests/support/shared_data.h"
#include "tests/synthesis/gait_clips.h"

namespace morphograph {
namespace {

using testing::GaitClip;

TEST(EvaluateClip, IgnoresHeadingFloorPositionAndFloorHeight) {
  const MotionClip clip = GaitClip(1);
  MotionClip moved = Moved(clip, 1.2, 30, -7);
  moved.root_positions().row(1).array() += 2.5;
  const ClipEvaluation a = EvaluateClip(clip), b = EvaluateClip(moved);
  EXPECT_NEAR(a.quality.contact_distance_m, b.quality.contact_distance_m, 1e-9);
  EXPECT_NEAR(a.quality.foot_skate_cm_s, b.quality.foot_skate_cm_s, 1e-6);
  EXPECT_NEAR(a.quality.penetration_m, b.quality.penetration_m, 1e-9);
  EXPECT_NEAR(a.quality.naturalness, b.quality.naturalness, 1e-12);
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  EXPECT_GE(a.contacts.size(), 12u);
}

TEST(EvaluateClip, HardlyDependsOnTheFrameRate) {
  const auto at_rate = [](double rate_hz) {
    return GaitClip(2, [&](SyntheticGaitOptions& options) { options.frame_rate_hz = rate_hz; });
  };
  const MotionClip slow = at_rate(30);
  const ClipEvaluation reference = EvaluateClip(slow);
  for (const double rate : {60.0, 120.0}) {
    const MotionClip fast = at_rate(rate);
    const ClipEvaluation evaluation = EvaluateClip(fast);
    EXPECT_NEAR(evaluation.quality.contact_distance_m, reference.quality.contact_distance_m, 1e-3) << rate;
    EXPECT_NEAR(evaluation.quality.foot_skate_cm_s, reference.quality.foot_skate_cm_s, 1.0) << rate;
    EXPECT_NEAR(evaluation.quality.naturalness / reference.quality.naturalness, 1, 0.25) << rate;
    EXPECT_NEAR(static_cast<double>(evaluation.contact_distance_m.size()), slow.frame_count(), 1) << rate;
    EXPECT_GT(evaluation.contacts.back().interval.last, slow.frame_count())
        << "contacts count the clip's own frames";
    EXPECT_LT(evaluation.contacts.back().interval.last, fast.frame_count());
  }
}

TEST(EvaluateClip, SeesFeetThatSlide) {
  MotionClip sliding = GaitClip(3);
  const double skate = EvaluateClip(sliding).quality.foot_skate_cm_s;
  for (int f = 0; f < sliding.frame_count(); ++f) sliding.root_positions()(0, f) += 0.2 * f / 30;
  // Sideways at 20 cm/s: a ball counts while it is low, about half of the time.
  EXPECT_GT(EvaluateClip(sliding).quality.foot_skate_cm_s, skate + 6);
  EXPECT_LT(EvaluateClip(sliding).quality.foot_skate_cm_s, skate + 20);
}

TEST(EvaluateClip, SeesFeetThatHover) {
  MotionClip bobbing = GaitClip(3);
  const double distance = EvaluateClip(bobbing).quality.contact_distance_m;
  for (int f = 0; f < bobbing.frame_count(); ++f) bobbing.root_positions()(1, f) += 0.01 * std::sin(0.3 * f);
  EXPECT_GT(EvaluateClip(bobbing).quality.contact_distance_m, distance + 0.003);
}

TEST(EvaluateClip, SeesShaking) {
  MotionClip shaking = GaitClip(3);
  const double naturalness = EvaluateClip(shaking).quality.naturalness;
  const int root = shaking.skeleton().moving_root();
  for (int f = 0; f < shaking.frame_count(); f += 9) {
    shaking.rotation(f, root) =
        shaking.rotation(f, root) * Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  }
  EXPECT_GT(EvaluateClip(shaking).quality.naturalness, 2 * naturalness);
}

TEST(EvaluateClip, OfABodyThatOnlyGlidesHasNoFrameDifference) {
  MotionClip gliding = GaitClip(4).Slice(0, 1);
  const MotionClip pose = gliding;
  gliding = MotionClip(pose.shared_skeleton(), 30, 60);
  for (int f = 0; f < 60; ++f) {
    for (int j = 0; j < pose.joint_count(); ++j) gliding.rotation(f, j) = pose.rotation(0, j);
    gliding.root_positions().col(f) = pose.root_positions().col(0) + Eigen::Vector3d(0.1 * f, 0, -0.05 * f);
  }
  const ClipEvaluation evaluation = EvaluateClip(gliding);
  ASSERT_EQ(evaluation.frame_difference.size(), 59u);
  for (const double difference : evaluation.frame_difference) EXPECT_NEAR(difference, 0, 1e-12);
  EXPECT_TRUE(evaluation.contacts.empty());
  EXPECT_EQ(evaluation.quality.contact_distance_m, 0);
}

TEST(EvaluateClip, RefusesWhatCannotBeMeasured) {
  const MotionClip clip = GaitClip(5);
  EXPECT_THROW(EvaluateClip(MotionClip()), std::invalid_argument);
  EXPECT_THROW(EvaluateClip(clip.Slice(0, 1)), std::invalid_argument);
  MotionClip broken = clip;
  broken.root_positions()(1, 40) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(EvaluateClip(broken), std::invalid_argument);
  const auto headless =
      std::make_shared<const Skeleton>(clip.skeleton().joints(), RoleMap(), 1.0, UpAxis::kY);
  EXPECT_THROW(EvaluateClip(MotionClip(headless, 30, 10)), std::invalid_argument);
}

TEST(EvaluateClip, FindsCapturedStancesOnATiltedFloor) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  for (const LoadedClip& loaded : LoadDataset({testing::SharedData() / "cmu" / "07"}).clips) {
    const ClipEvaluation evaluation = EvaluateClip(loaded.clip);
    EXPECT_LT(evaluation.quality.contact_distance_m, 0.015) << loaded.clip.name;  // the floor rises by 7 cm
    EXPECT_GE(evaluation.contacts.size(), 3u) << loaded.clip.name;
  }
}

TEST(CheckBody, PassesAWalkAndSeesAKneeThatBendsBack) {
  MotionClip clip = GaitClip(6);
  const BodyCheck walk = CheckBody(PrepareEvaluation(clip));
  EXPECT_GT(walk.min_knee_flexion_deg, -1);
  EXPECT_GT(walk.max_knee_flexion_deg, 40);
  EXPECT_LT(walk.bone_length_error_m, 1e-9);

  const int knee = clip.skeleton().roles()[JointRole::kLeftKnee];
  for (const int f : {50, 51, 52}) {
    clip.rotation(f, knee) =
        clip.rotation(f, knee) * Eigen::Quaterniond(Eigen::AngleAxisd(-2.0, Eigen::Vector3d::UnitX()));
  }
  EXPECT_LT(CheckBody(PrepareEvaluation(clip)).min_knee_flexion_deg, -30);
}

TEST(CheckBody, SeesABoneThatStretches) {
  EvaluationMotion motion = PrepareEvaluation(GaitClip(7));
  const int head = motion.skeleton->roles()[JointRole::kHead];
  const int parent = motion.skeleton->parent(head);
  const Eigen::Vector3d bone = motion.joint_positions[30].col(head) - motion.joint_positions[30].col(parent);
  motion.joint_positions[30].col(head) += 0.01 * bone.normalized();
  EXPECT_NEAR(CheckBody(motion).bone_length_error_m, 0.01, 1e-9);
}

}  // namespace
}  // namespace morphograph
