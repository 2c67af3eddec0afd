#include "datasets/synthetic_gait.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "datasets/forward_kinematics.h"
#include "datasets/gait_curves.h"
#include "datasets/leg_ik.h"
#include "datasets/synthetic_skeleton.h"

namespace morphograph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct NamedGait {
  const char* name;
  SyntheticGaitOptions options;
};

std::vector<NamedGait> Gaits() {
  std::vector<NamedGait> gaits = {{"plain", {}}, {"slow", {}}, {"fast", {}}, {"long_steps", {}}, {"turning", {}}, {"old", {}},
                                  {"wild", {}}, {"small", {}}, {"cut", {}}};
  gaits[1].options.speed_m_s = 0.5;
  gaits[2].options.speed_m_s = 1.9;
  gaits[3].options.speed_m_s = 1.5;
  gaits[3].options.step_length_m = 0.95;
  gaits[4].options.turns_rad = {0.0, 0.3, 0.35, -0.2, -0.35};
  gaits[5].options.stoop_rad = 0.5;
  gaits[5].options.knee_bend_rad = 0.25;
  gaits[5].options.speed_m_s = 0.8;
  gaits[5].options.step_width_m = 0.18;
  gaits[6].options.variation = 3;
  gaits[6].options.foot_lift = 0.5;
  gaits[6].options.arm_swing = 2.5;
  gaits[7].options.stature_m = 1.1;
  gaits[7].options.left_first = false;
  gaits[8].options.start_standing = false;
  gaits[8].options.stop_standing = false;
  gaits[8].options.frame_rate_hz = 120;
  return gaits;
}

class SyntheticGaitTest : public ::testing::TestWithParam<NamedGait> {};

TEST_P(SyntheticGaitTest, PlantedPointsDoNotMove) {
  const SyntheticGaitOptions& options = GetParam().options;
  SyntheticGaitTruth truth;
  const MotionClip clip = GenerateGait(options, &truth);
  const SyntheticFoot shape(options.stature_m);
  int checked = 0;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const double t = f / clip.frame_rate_hz();
    const WorldPose pose = ForwardKinematics(clip, f);
    for (const auto& plant : truth.plants) {
      if (t < plant.from_s || t > plant.to_s) continue;
      const RoleMap& roles = clip.skeleton().roles();
      const bool left = plant.foot == Foot::kLeft;
      const int ankle = roles[left ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
      const int toe = roles[left ? JointRole::kLeftToe : JointRole::kRightToe];
      const Vector3d heel = pose.positions.col(ankle) +
                            pose.rotations[ankle] * Vector3d(0, -shape.ankle_height_m, -shape.heel_behind_m);
      const Vector3d point = plant.heel ? heel : Vector3d(pose.positions.col(toe));
      ASSERT_LT((point - plant.position_m).norm(), 1e-6) << "frame " << f << (plant.heel ? " heel" : " ball");
      ++checked;
    }
  }
  EXPECT_GT(checked, 1.7 * clip.frame_count());  // heel or ball or both, of one foot or both
}

TEST_P(SyntheticGaitTest, KneesBendForwardsAndNothingIsBelowTheFloor) {
  const MotionClip clip = GenerateGait(GetParam().options);
  const SyntheticFoot shape(GetParam().options.stature_m);
  const LegIk legs[] = {LegIk(clip.skeleton(), Foot::kLeft), LegIk(clip.skeleton(), Foot::kRight)};
  double least_bend = 10, most_bend = 0, lowest = 10;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(clip, f);
    for (const LegIk& leg : legs) {
      const double bend = leg.Measure(clip.root_positions().col(f), clip.rotations(f)).knee_bend_rad;
      least_bend = std::min(least_bend, bend);
      most_bend = std::max(most_bend, bend);
      const Vector3d toes = pose.positions.col(leg.toe());
      lowest = std::min({lowest, toes.y() - shape.ball_height_m,
                         (pose.positions.col(leg.ankle()) +
                          pose.rotations[leg.ankle()] * Vector3d(0, -shape.ankle_height_m, -shape.heel_behind_m)).y(),
                         (toes + pose.rotations[leg.toe()] * *clip.skeleton().joint(leg.toe()).end_site_m).y()});
    }
  }
  EXPECT_GT(least_bend, 0.003);
  EXPECT_LT(most_bend, 1.8);
  EXPECT_GT(most_bend, 0.6);
  EXPECT_GT(lowest, -1e-3);
}

TEST_P(SyntheticGaitTest, MovesWithoutPops) {
  const MotionClip clip = GenerateGait(GetParam().options);
  const double dt = 1 / clip.frame_rate_hz();
  const std::vector<Eigen::Matrix3Xd> positions = JointPositions(clip);
  double fastest = 0, hardest = 0;
  for (int f = 1; f + 1 < clip.frame_count(); ++f) {
    const Eigen::Matrix3Xd acceleration = (positions[f + 1] - 2 * positions[f] + positions[f - 1]) / (dt * dt);
    fastest = std::max(fastest, ((positions[f + 1] - positions[f]) / dt).colwise().norm().maxCoeff());
    hardest = std::max(hardest, acceleration.colwise().norm().maxCoeff());
  }
  EXPECT_LT(fastest, 4 * GetParam().options.speed_m_s + 1.2);  // swing feet go about three times as fast as the body
  EXPECT_LT(hardest, 300);
}

TEST_P(SyntheticGaitTest, KeepsTheAskedSpeedAndTurns) {
  const SyntheticGaitOptions& options = GetParam().options;
  SyntheticGaitTruth truth;
  const MotionClip clip = GenerateGait(options, &truth);
  ASSERT_GE(truth.strikes.size(), 10u);
  double length = 0, time = 0;
  for (size_t k = 2; k + 3 < truth.strikes.size(); ++k) {
    // Along the path: the mean of two successive strides' halves has no step width in it.
    const Vector2d from = (truth.strikes[k].ankle_m + truth.strikes[k - 1].ankle_m) / 2;
    const Vector2d to = (truth.strikes[k + 1].ankle_m + truth.strikes[k].ankle_m) / 2;
    length += (to - from).norm();
    time += truth.strikes[k + 1].time_s - truth.strikes[k].time_s;
  }
  EXPECT_NEAR(length / time / options.speed_m_s, 1, 0.03 + 0.04 * options.variation / 3);

  double turn = 0;
  for (int k = 0; k < options.steps; ++k) {
    if (!options.turns_rad.empty()) turn += options.turns_rad[std::min<size_t>(k, options.turns_rad.size() - 1)];
  }
  if (options.stop_standing) {
    EXPECT_NEAR(std::remainder(HeadingRad(clip, clip.frame_count() - 1) - options.heading_rad - turn, 2 * M_PI), 0, 1e-6);
  }
}

class StandingGaitTest : public SyntheticGaitTest {};

TEST_P(StandingGaitTest, StandsStillBeforeAndAfter) {
  const SyntheticGaitOptions& options = GetParam().options;
  const MotionClip clip = GenerateGait(options);
  const std::vector<Eigen::Matrix3Xd> positions = JointPositions(clip);
  const int still = static_cast<int>((options.stand_s - 0.3) * options.frame_rate_hz);
  for (int f = 1; f < still; ++f) {
    ASSERT_LT((positions[f] - positions[0]).cwiseAbs().maxCoeff(), 2e-3) << f;
    ASSERT_LT((positions[positions.size() - 1 - f] - positions.back()).cwiseAbs().maxCoeff(), 2e-3) << f;
  }
  const int middle = clip.frame_count() / 2;
  EXPECT_GT((positions[middle] - positions[0]).norm(), 1);
  const RoleMap& roles = clip.skeleton().roles();
  const Vector3d apart = positions.back().col(roles[JointRole::kLeftAnkle]) - positions.back().col(roles[JointRole::kRightAnkle]);
  EXPECT_LT(apart.norm(), 0.45);
}

// Gaits() without those that are cut out of a walk.
std::vector<NamedGait> StandingGaits() {
  std::vector<NamedGait> gaits = Gaits();
  std::erase_if(gaits, [](const NamedGait& gait) { return !gait.options.start_standing || !gait.options.stop_standing; });
  return gaits;
}

INSTANTIATE_TEST_SUITE_P(Gaits, StandingGaitTest, ::testing::ValuesIn(StandingGaits()),
                         [](const auto& given) { return std::string(given.param.name); });
INSTANTIATE_TEST_SUITE_P(Gaits, SyntheticGaitTest, ::testing::ValuesIn(Gaits()),
                         [](const auto& given) { return std::string(given.param.name); });

TEST(SyntheticGait, SameSeedSameClipOtherSeedOtherClip) {
  SyntheticGaitOptions options;
  const MotionClip a = GenerateGait(options), b = GenerateGait(options);
  ASSERT_EQ(a.frame_count(), b.frame_count());
  EXPECT_EQ(a.root_positions(), b.root_positions());
  for (int j = 0; j < a.joint_count(); ++j) EXPECT_EQ(a.rotation(77, j).coeffs(), b.rotation(77, j).coeffs());
  options.seed = 2;
  const MotionClip c = GenerateGait(options);
  EXPECT_GT((a.root_positions().col(200) - c.root_positions().col(200)).norm(), 1e-3);
}

TEST(SyntheticGait, FrameRateOnlySamplesTheMotion) {
  SyntheticGaitOptions options;
  options.frame_rate_hz = 30;
  const MotionClip slow = GenerateGait(options);
  options.frame_rate_hz = 120;
  const MotionClip fast = GenerateGait(options);
  for (int f = 0; f < slow.frame_count(); ++f) {
    ASSERT_LT((slow.root_positions().col(f) - fast.root_positions().col(4 * f)).norm(), 1e-9);
    ASSERT_LT(slow.rotation(f, 2).angularDistance(fast.rotation(4 * f, 2)), 1e-6);
  }
}

TEST(SyntheticGait, WithoutVariationStepsAreAlikeAndWithItTheyDiffer) {
  SyntheticGaitOptions options;
  for (const double variation : {0.0, 1.0}) {
    options.variation = variation;
    SyntheticGaitTruth truth;
    GenerateGait(options, &truth);
    double shortest = 10, longest = 0;
    for (int k = 3; k < 8; ++k) {
      const double step_s = truth.strikes[k + 1].time_s - truth.strikes[k].time_s;
      shortest = std::min(shortest, step_s);
      longest = std::max(longest, step_s);
    }
    if (variation == 0) {
      EXPECT_NEAR(longest, shortest, 1e-9);
    } else {
      EXPECT_GT(longest - shortest, 0.005);
    }
  }
}

TEST(SyntheticGait, StartsWhereAndHowAsked) {
  SyntheticGaitOptions options;
  options.start_m = {2, -3};
  options.heading_rad = 1.2;
  const MotionClip clip = GenerateGait(options);
  EXPECT_NEAR(clip.root_positions()(0, 0), 2, 1e-3);
  EXPECT_NEAR(clip.root_positions()(2, 0), -3, 1e-3);
  EXPECT_NEAR(HeadingRad(clip, 0), 1.2, 1e-6);
  const Vector3d gone = clip.root_positions().col(clip.frame_count() - 1) - clip.root_positions().col(0);
  EXPECT_NEAR(std::atan2(gone.x(), gone.z()), 1.2, 0.02);
}

TEST(SyntheticGait, FasterWalksTakeLongerAndQuickerSteps) {
  double last_step_m = 0, last_step_s = 10;
  for (const double speed : {0.6, 1.0, 1.4, 1.8}) {
    SyntheticGaitOptions options;
    options.speed_m_s = speed;
    options.variation = 0;
    SyntheticGaitTruth truth;
    GenerateGait(options, &truth);
    const double step_s = truth.strikes[5].time_s - truth.strikes[4].time_s;
    const double step_m = (truth.strikes[6].ankle_m - truth.strikes[4].ankle_m).norm() / 2;
    EXPECT_GT(step_m, last_step_m);
    EXPECT_LT(step_s, last_step_s);
    last_step_m = step_m;
    last_step_s = step_s;
  }
}

TEST(SyntheticGait, SaysWhichOptionIsWrong) {
  SyntheticGaitOptions options;
  EXPECT_FALSE(options.FirstProblem());
  options.stoop_rad = std::nan("");
  ASSERT_TRUE(options.FirstProblem());
  EXPECT_EQ(options.FirstProblem()->first, "stoop_rad");
  EXPECT_THAT([&] { GenerateGait(options); }, ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("stoop_rad")));
  options.stoop_rad = 0;
  options.turns_rad = {0.1, 0.7};
  EXPECT_EQ(options.FirstProblem()->first, "turns_rad");
}

TEST(GaitCurves, PassThroughTypicalAngles) {
  const double degree = M_PI / 180;
  EXPECT_NEAR(gait_curves::kHipFlexion.AtRad(0) / degree, 30, 1.5);
  EXPECT_NEAR(gait_curves::kHipFlexion.AtRad(0.5) / degree, -10, 1.5);
  EXPECT_NEAR(gait_curves::kKneeFlexion.AtRad(0.14) / degree, 18, 1.5);
  EXPECT_NEAR(gait_curves::kKneeFlexion.AtRad(0.73) / degree, 61, 1.5);
  EXPECT_NEAR(gait_curves::kAnkleDorsiflexion.AtRad(0.64) / degree, -18, 1.5);
  EXPECT_NEAR(gait_curves::kKneeFlexion.AtRad(1.14), gait_curves::kKneeFlexion.AtRad(0.14), 1e-12);
}

}  // namespace
}  // namespace morphograph
