#include "datasets/contact_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "datasets/forward_kinematics.h"
#include "datasets/low_pass.h"
#include "datasets/noise_model.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

SyntheticGaitOptions WalkAt(double frame_rate_hz) {
  SyntheticGaitOptions options;
  options.frame_rate_hz = frame_rate_hz;
  options.steps = 8;
  return options;
}

// The clip on a floor that rises along +Z (the way walked) by `slope`, the body sheared upright over it.
MotionClip OnSlope(MotionClip clip, double slope) {
  for (int f = 0; f < clip.frame_count(); ++f) clip.root_positions()(1, f) += slope * clip.root_positions()(2, f);
  return clip;
}

class ContactDetector : public ::testing::TestWithParam<double> {};

TEST_P(ContactDetector, StancesBeginAtTheStrikesOfAMadeWalk) {
  SyntheticGaitTruth truth;
  const MotionClip clip = GenerateGait(WalkAt(GetParam()), &truth);
  const ContactTrack track = DetectContacts(clip);
  for (const SyntheticGaitTruth::Strike& strike : truth.strikes) {
    double nearest = 1e9;
    for (const ContactInterval& contact : track.intervals) {
      if (contact.foot != strike.foot || contact.first == 0) continue;
      nearest = std::min(nearest, std::abs(contact.first / GetParam() - strike.time_s));
    }
    EXPECT_LE(nearest, 0.08) << FootName(strike.foot) << " strike at " << strike.time_s << " s";
  }
  // As many stances as strikes, and the two that the walk begins with.
  EXPECT_EQ(track.intervals.size(), truth.strikes.size() + 2);
}

TEST_P(ContactDetector, FollowsASlopedFloor) {
  const MotionClip level = GenerateGait(WalkAt(GetParam()));
  const ContactTrack flat = DetectContacts(level);
  const double slope = 0.04;
  const ContactTrack sloped = DetectContacts(OnSlope(level, slope));
  ASSERT_TRUE(sloped.plane.has_value());
  EXPECT_NEAR(sloped.plane->slope.y(), slope, 0.01);
  ASSERT_EQ(sloped.intervals.size(), flat.intervals.size());
  const int last = level.frame_count() - 1;
  EXPECT_NEAR(sloped.ground_m[last] - sloped.ground_m[0],
              slope * (level.root_positions()(2, last) - level.root_positions()(2, 0)), 0.02);
}

INSTANTIATE_TEST_SUITE_P(FrameRates, ContactDetector, ::testing::Values(30.0, 60.0, 100.0, 120.0));

TEST(ContactDetectorTest, IgnoresHeadingAndFloorPosition) {
  const MotionClip clip = GenerateGait(WalkAt(60));
  const ContactTrack here = DetectContacts(clip);
  const ContactTrack there = DetectContacts(Moved(clip, 2.1, -30, 12));
  EXPECT_TRUE((here.planted == there.planted).all());
  EXPECT_LT((here.ground_m - there.ground_m).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ContactDetectorTest, HeelsAndBallsOfPlantedFeetLieOnTheGround) {
  const MotionClip clip = GenerateGait(WalkAt(60));
  const ContactTrack track = DetectContacts(clip);
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int side = 0; side < 2; ++side) {
      if (track.planted(2 * side, f) && track.planted(2 * side + 1, f)) {
        EXPECT_NEAR(track.heels[side](1, f), track.ground_m[f], 0.045);
        EXPECT_NEAR(track.balls[side](1, f), track.ground_m[f], 0.045);
      }
    }
  }
}

// The clip at a part of its speed.
MotionClip Slowed(const MotionClip& clip, double part) {
  MotionClip slow(clip.shared_skeleton(), part * clip.frame_rate_hz(), clip.frame_count());
  slow.root_positions() = clip.root_positions();
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int joint = 0; joint < clip.joint_count(); ++joint) slow.rotation(f, joint) = clip.rotation(f, joint);
  }
  return slow;
}

// Where the heel lies in the frame of a foot, as the track has it.
Eigen::Vector3d HeelInFoot(const MotionClip& clip, const ContactTrack& track, int side) {
  const int ankle = clip.skeleton().roles()[side == 0 ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
  const WorldPose pose = ForwardKinematics(clip, 0);
  return pose.rotations[ankle].conjugate() * (track.heels[side].col(0) - pose.positions.col(ankle));
}

// Whoever walks slowly lifts a heel slowly too: frames in which it is on its way up are no flat stance.
TEST(ContactDetectorTest, TheHeelLiesInTheFootWhereItDoesHoweverSlowTheWalk) {
  const MotionClip whole = GenerateGait(WalkAt(60));
  const MotionClip clip = whole.Slice(90, whole.frame_count() - 180);  // without the stands at its ends
  const ContactTrack usual = DetectContacts(clip);
  for (const double part : {0.5, 0.25, 0.1}) {
    const MotionClip slowed = Slowed(clip, part);
    const ContactTrack slow = DetectContacts(slowed);
    for (int side = 0; side < 2; ++side) {
      EXPECT_LT((HeelInFoot(slowed, slow, side) - HeelInFoot(clip, usual, side)).norm(), 0.001) << part;
    }
  }
}

TEST(ContactDetectorTest, TakesShortClips) {
  const MotionClip clip = GenerateGait(WalkAt(60));
  EXPECT_TRUE(DetectContacts(clip.Slice(0, 0)).intervals.empty());
  EXPECT_EQ(DetectContacts(clip.Slice(5, 1)).ground_m.size(), 1);
  EXPECT_EQ(DetectContacts(clip.Slice(5, 2)).planted.cols(), 2);
}

TEST(ContactDetectorTest, BothFeetStandThroughAStand) {
  const MotionClip stand = GenerateGait(WalkAt(60)).Slice(0, 30);
  const ContactTrack track = DetectContacts(stand);
  ASSERT_EQ(track.intervals.size(), 2u);
  for (const ContactInterval& contact : track.intervals) {
    EXPECT_EQ(contact.first, 0);
    EXPECT_EQ(contact.last, 29);
  }
}

// Unsmoothed, feet that jitter by 3 cm a frame never are slow, and nothing can be learned of such a capture.
TEST(ContactDetectorTest, FindsTheStancesOfAJitteryCapture) {
  for (const double rate : {30.0, 120.0}) {
    SyntheticGaitOptions options = WalkAt(rate);
    options.steps = 20;
    const MotionClip clip = GenerateGait(options);
    NoiseOptions noise;
    noise.slips_per_s = noise.dropouts_per_s = 0;
    const ContactTrack clean = DetectContacts(clip), noisy = DetectContacts(AddNoise(clip, noise, 3));
    const auto standing = [&](const ContactTrack& track, int side, int f) { return track.planted.col(f).segment<2>(2 * side).any(); };
    int same = 0;
    for (int f = 0; f < clip.frame_count(); ++f) {
      for (int side = 0; side < 2; ++side) same += standing(clean, side, f) == standing(noisy, side, f);
    }
    EXPECT_GT(same / (2.0 * clip.frame_count()), 0.85) << rate;
    EXPECT_NEAR(static_cast<double>(noisy.intervals.size()), static_cast<double>(clean.intervals.size()), 3) << rate;
  }
}

TEST(ContactDetectorTest, NamesMissingJoints) {
  RoleMap roles;
  roles.Set(JointRole::kHips, 0);
  const auto skeleton =
      std::make_shared<const Skeleton>(std::vector<Joint>{{"Hips", -1, {}, {}, {}}}, roles, 1.0, UpAxis::kY);
  EXPECT_THROW(DetectContacts(MotionClip(skeleton, 30, 3)), std::invalid_argument);
}

TEST(LowPass, KeepsSlowAndHalvesAtTheCutoff) {
  const double rate = 120, cutoff = 10;
  const auto gain = [&](double hz) {
    Eigen::MatrixXd wave(1, 600);
    for (int i = 0; i < 600; ++i) wave(0, i) = std::sin(2 * std::numbers::pi * hz * i / rate);
    return LowPass(wave, rate, cutoff).middleCols(200, 200).cwiseAbs().maxCoeff();
  };
  EXPECT_NEAR(gain(1), 1.0, 0.01);
  EXPECT_NEAR(gain(cutoff), 0.5, 0.02);
  EXPECT_LT(gain(40), 0.02);
}

TEST(LowPass, KeepsStraightLinesAndPhase) {
  Eigen::MatrixXd line(1, 100);
  for (int i = 0; i < 100; ++i) line(0, i) = 3 + 0.2 * i;
  EXPECT_LT((LowPass(line, 120, 10) - line).cwiseAbs().maxCoeff(), 1e-3);
  Eigen::MatrixXd bump(1, 101);
  for (int i = 0; i < 101; ++i) bump(0, i) = std::exp(-0.5 * std::pow((i - 50) / 6.0, 2));
  const Eigen::MatrixXd smooth = LowPass(bump, 120, 10);
  EXPECT_LT((smooth - smooth.rowwise().reverse()).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(LowPass, RefusesBadRates) {
  EXPECT_THROW(LowPass(Eigen::MatrixXd::Zero(1, 9), 0, 10), std::invalid_argument);
  EXPECT_THROW(LowPass(Eigen::MatrixXd::Zero(1, 9), 120, -1), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
