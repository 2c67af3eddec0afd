#include "datasets/noise_model.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <set>

#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

using Eigen::Vector3d;

NoiseOptions Silent() {
  NoiseOptions options;
  options.leaf_jitter_rad = options.root_jitter_m = options.root_jitter_rad = options.slips_per_s = options.dropouts_per_s = 0;
  return options;
}

MotionClip MakeWalk(double rate_hz, int steps) {
  SyntheticGaitOptions options;
  options.frame_rate_hz = rate_hz;
  options.steps = steps;
  MotionClip clip = GenerateGait(options);
  clip.name = "walk_001";
  return clip;
}

const MotionClip& LongWalk() {
  static const MotionClip clip = MakeWalk(30, 60);
  return clip;
}

const MotionClip& TenStepWalk() {
  static const MotionClip clip = MakeWalk(30, 10);
  return clip;
}

Vector3d TurnBetween(const MotionClip& clean, const MotionClip& noisy, int frame, int joint) {
  const Eigen::AngleAxisd turn(clean.rotation(frame, joint).conjugate() * noisy.rotation(frame, joint));
  const double angle = std::remainder(turn.angle(), 2 * M_PI);
  return turn.axis() * angle;
}

bool Same(const MotionClip& a, const MotionClip& b) {
  if ((a.root_positions().array() != b.root_positions().array()).any()) return false;
  for (int f = 0; f < a.frame_count(); ++f) {
    for (int j = 0; j < a.joint_count(); ++j) {
      if ((a.rotation(f, j).coeffs().array() != b.rotation(f, j).coeffs().array()).any()) return false;
    }
  }
  return true;
}

double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(NoiseModel, IsTheSameForTheSameClipAndSeedAndAnotherForOthers) {
  const MotionClip& clip = TenStepWalk();
  MotionClip renamed = clip;
  renamed.name = "walk_002";
  EXPECT_TRUE(Same(AddNoise(clip, {}, 7), AddNoise(clip, {}, 7)));
  EXPECT_FALSE(Same(AddNoise(clip, {}, 7), AddNoise(clip, {}, 8)));
  EXPECT_FALSE(Same(AddNoise(clip, {}, 7), AddNoise(clip, {}, 7 + (std::uint64_t{1} << 40))));
  EXPECT_FALSE(Same(AddNoise(clip, {}, 7), AddNoise(renamed, {}, 7)));
}

TEST(NoiseModel, WithoutNoiseIsTheClipItself) {
  const MotionClip& clip = TenStepWalk();
  EXPECT_TRUE(Same(AddNoise(clip, Silent(), 3), clip));
}

TEST(NoiseModel, LimbsEndInHeadHandsAndFeet) {
  const Skeleton& skeleton = TenStepWalk().skeleton();
  const std::vector<std::vector<int>> limbs = NoisyLimbs(skeleton);
  ASSERT_EQ(limbs.size(), 5u);
  EXPECT_EQ(limbs[1].front(), skeleton.roles()[JointRole::kLeftElbow]);
  EXPECT_EQ(limbs[4].front(), skeleton.roles()[JointRole::kRightKnee]);
  EXPECT_THAT(limbs[4], ::testing::Contains(skeleton.roles()[JointRole::kRightToe]));
  std::set<int> all;
  for (const std::vector<int>& limb : limbs) {
    for (const int joint : limb) EXPECT_TRUE(all.insert(joint).second) << "joint " << joint << " is in two limbs";
  }
  for (const JointRole inner : {JointRole::kHips, JointRole::kSpine, JointRole::kChest, JointRole::kLeftHip, JointRole::kRightShoulder}) {
    EXPECT_FALSE(all.contains(skeleton.roles()[inner])) << RoleName(inner);
  }
}

TEST(NoiseModel, LeavesWithTheirParentsWhereThereAreNoRoles) {
  std::vector<Joint> joints(5);
  const char* names[] = {"base", "a", "b", "c", "d"};
  const int parents[] = {-1, 0, 1, 2, 1};  // base - a - b - c and a - d
  for (int j = 0; j < 5; ++j) joints[j].name = names[j], joints[j].parent = parents[j], joints[j].offset_m = Vector3d(0, 0.1, 0);
  const Skeleton skeleton(joints, RoleMap(), 1, UpAxis::kY);
  EXPECT_THAT(NoisyLimbs(skeleton), ::testing::ElementsAre(::testing::ElementsAre(2, 3), ::testing::ElementsAre(1, 4)));
}

// A chest that carries head and arms must not turn with the head, or inner joints would be noisy.
TEST(NoiseModel, AJointThatCarriesSeveralEndsIsNoPartOfALimb) {
  std::vector<Joint> joints(4);
  const char* names[] = {"Hips", "Chest", "Head", "LeftWrist"};
  const int parents[] = {-1, 0, 1, 1};
  for (int j = 0; j < 4; ++j) joints[j].name = names[j], joints[j].parent = parents[j], joints[j].offset_m = Vector3d(0.1, 0.1, 0);
  RoleMap roles;
  roles.Set(JointRole::kHips, 0), roles.Set(JointRole::kHead, 2), roles.Set(JointRole::kLeftWrist, 3);
  EXPECT_THAT(NoisyLimbs(Skeleton(joints, roles, 1, UpAxis::kY)), ::testing::ElementsAre(::testing::ElementsAre(2), ::testing::ElementsAre(3)));
}

TEST(NoiseModel, TouchesNeitherBonesNorInnerJoints) {
  const MotionClip &clip = TenStepWalk(), noisy = AddNoise(clip, {}, 5);
  std::set<int> touched = {clip.skeleton().moving_root()};
  for (const std::vector<int>& limb : NoisyLimbs(clip.skeleton())) touched.insert(limb.begin(), limb.end());
  for (int f = 0; f < clip.frame_count(); f += 3) {
    const WorldPose pose = ForwardKinematics(noisy, f);
    for (int j = 0; j < clip.joint_count(); ++j) {
      if (touched.contains(j)) {
        EXPECT_NEAR(noisy.rotation(f, j).norm(), 1, 1e-12);
      } else {
        ASSERT_EQ((noisy.rotation(f, j).coeffs() - clip.rotation(f, j).coeffs()).norm(), 0) << clip.skeleton().joint(j).name;
      }
      const int parent = clip.skeleton().parent(j);
      if (!clip.skeleton().IsBody(j) || j == clip.skeleton().moving_root()) continue;
      ASSERT_NEAR((pose.positions.col(j) - pose.positions.col(parent)).norm(), clip.skeleton().joint(j).offset_m.norm(), 1e-12);
    }
  }
}

TEST(NoiseModel, JitterIsWhiteWithTheDeviationAsked) {
  const MotionClip& clip = LongWalk();
  NoiseOptions options = Silent();
  options.leaf_jitter_rad = 0.07, options.root_jitter_m = 0.01, options.root_jitter_rad = 0.03;
  const MotionClip noisy = AddNoise(clip, options, 11);
  const int root = clip.skeleton().moving_root(), ankle = clip.skeleton().roles()[JointRole::kLeftAnkle];
  std::vector<double> at_ankle, at_root, shift;
  double next_to_each_other = 0;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const Vector3d turn = TurnBetween(clip, noisy, f, ankle);
    if (f > 0) next_to_each_other += turn.dot(TurnBetween(clip, noisy, f - 1, ankle));
    for (int d = 0; d < 3; ++d) {
      at_ankle.push_back(turn[d]);
      at_root.push_back(TurnBetween(clip, noisy, f, root)[d]);
      shift.push_back((noisy.root_positions() - clip.root_positions())(d, f));
    }
  }
  ASSERT_GT(at_ankle.size(), 2000u);
  EXPECT_NEAR(RootMeanSquare(at_ankle), 0.07, 0.004);
  EXPECT_NEAR(RootMeanSquare(at_root), 0.03, 0.002);
  EXPECT_NEAR(RootMeanSquare(shift), 0.01, 0.0006);
  const double correlation = next_to_each_other / (static_cast<double>(at_ankle.size()) * 0.07 * 0.07);
  EXPECT_NEAR(correlation, 0, 0.08);
}

TEST(NoiseModel, AFasterClipShowsTheSameCamera) {
  NoiseOptions options = Silent();
  options.root_jitter_m = 0.01, options.camera_hz = 30;
  const MotionClip clip = MakeWalk(120, 30), noisy = AddNoise(clip, options, 2);
  const Eigen::Matrix3Xd shift = noisy.root_positions() - clip.root_positions();
  double at_frames = 0, steps = 0;
  const int count = (clip.frame_count() - 4) / 4;
  for (int i = 0; i < count; ++i) {
    at_frames += shift.col(4 * i).squaredNorm() / (3 * count);  // at the camera's own frames
    steps += (shift.col(4 * i + 1) - shift.col(4 * i)).squaredNorm() / (3 * count);
  }
  EXPECT_NEAR(std::sqrt(at_frames), 0.01, 0.0008);
  EXPECT_LT(std::sqrt(steps), 0.006);  // white noise at 120 Hz would step by 0.014
}

// Mean square of a slip over time: rate * length * deviation^2 * mean of sin^4 = 3/8.
TEST(NoiseModel, SlipsComeAsOftenAndAsFarAsAsked) {
  NoiseOptions options = Silent();
  options.slips_per_s = 0.5, options.slip_rad = 0.2, options.slip_m = 0.06, options.slip_s = 0.4;
  double turned = 0, shifted = 0, frames = 0;
  for (int n = 0; n < 6; ++n) {
    MotionClip clip = LongWalk();
    clip.name += std::to_string(n);
    const MotionClip noisy = AddNoise(clip, options, 3);
    const int elbow = clip.skeleton().roles()[JointRole::kLeftElbow], wrist = clip.skeleton().roles()[JointRole::kLeftWrist];
    for (int f = 0; f < clip.frame_count(); ++f) {
      turned += TurnBetween(clip, noisy, f, elbow).squaredNorm();
      shifted += (noisy.root_positions() - clip.root_positions()).col(f).squaredNorm();
      ASSERT_LT(TurnBetween(clip, noisy, f, wrist).norm(), 1e-9) << "the limb turns as one";
    }
    frames += clip.frame_count();
  }
  EXPECT_NEAR(turned / frames, 0.5 * 0.4 * 0.2 * 0.2 * 3 / 8, 0.0012);
  EXPECT_NEAR(shifted / frames, 0.5 * 0.4 * 0.06 * 0.06 * 3 / 8, 0.00011);
}

TEST(NoiseModel, DropoutsFreezeALimbForAsLongAsAskedAndThenItIsBack) {
  NoiseOptions options = Silent();
  options.dropouts_per_s = 0.25, options.dropout_s = 0.3;
  int frozen = 0, back = 0, frames = 0;
  for (int n = 0; n < 6; ++n) {
    MotionClip clip = LongWalk();
    clip.name += std::to_string(n);
    const MotionClip noisy = AddNoise(clip, options, 9);
    const int knee = clip.skeleton().roles()[JointRole::kRightKnee], ankle = clip.skeleton().roles()[JointRole::kRightAnkle];
    int held = 0;
    for (int f = 0; f < clip.frame_count(); ++f) {
      const bool as_captured = (noisy.rotation(f, knee).coeffs() - clip.rotation(f, knee).coeffs()).norm() == 0;
      if (as_captured) {
        back += held > 0, held = 0;
        continue;
      }
      ++frozen, ++held;
      ASSERT_EQ((noisy.rotation(f, knee).coeffs() - noisy.rotation(f - 1, knee).coeffs()).norm(), 0) << f;
      ASSERT_EQ((noisy.rotation(f, ankle).coeffs() - noisy.rotation(f - 1, ankle).coeffs()).norm(), 0) << f;
    }
    frames += clip.frame_count();
  }
  // 0.25 a second of 0.3 s: 7 % of the frames, a little less where dropouts overlap or begin before the clip.
  EXPECT_NEAR(static_cast<double>(frozen) / frames, 0.07, 0.02);
  EXPECT_GT(back, 20);
}

TEST(NoiseModel, OneKindDoesNotShiftTheOthers) {
  const MotionClip& clip = TenStepWalk();
  NoiseOptions jitter = Silent(), both = Silent();
  jitter.root_jitter_m = both.root_jitter_m = 0.01;
  both.slips_per_s = 1, both.slip_m = 0;
  EXPECT_LT((AddNoise(clip, jitter, 4).root_positions() - AddNoise(clip, both, 4).root_positions()).norm(), 1e-12);
}

TEST(NoiseModel, NamesTheOptionAtFault) {
  const auto message = [](const NoiseOptions& options) -> std::string {
    try {
      AddNoise(TenStepWalk(), options, 1);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  NoiseOptions options;
  options.slip_rad = -0.1;
  EXPECT_THAT(message(options), ::testing::HasSubstr("slip_rad is -0.1"));
  options = {};
  options.dropout_s = 0;
  EXPECT_THAT(message(options), ::testing::HasSubstr("dropout_s"));
  options = {};
  options.leaf_jitter_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(options), ::testing::HasSubstr("leaf_jitter_rad"));
}

}  // namespace
}  // namespace morphograph
