#include "datasets/bend.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/floor_leveling.h"
#include "datasets/forward_kinematics.h"
#include "datasets/leg_ik.h"
#include "datasets/synthetic_gait.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using Eigen::Vector3d;

/// Farthest that the ball or the ankle of a planted foot moves from the first frame of the flat part of its stance.
struct Slips {
  double worst_m = 0, mean_m = 0;
};

Slips PlantedSlips(const MotionClip& clip, const MotionClip& original, const ContactTrack& contacts) {
  Slips slips;
  int stances = 0;
  const auto after = JointPositions(clip), before = JointPositions(original);
  for (const ContactInterval& interval : contacts.intervals) {
    const bool left = interval.foot == Foot::kLeft;
    const int toe = clip.skeleton().roles()[left ? JointRole::kLeftToe : JointRole::kRightToe];
    // Compare how much the ball wanders within the stance, before and after.
    double own = 0, bent = 0;
    const int middle = (interval.first + interval.last) / 2;
    for (int f = interval.first; f <= interval.last; ++f) {
      own = std::max(own, (before[f].col(toe) - before[middle].col(toe)).norm());
      bent = std::max(bent, (after[f].col(toe) - after[middle].col(toe)).norm());
    }
    slips.worst_m = std::max(slips.worst_m, bent - own);
    slips.mean_m += bent - own;
    ++stances;
  }
  if (stances > 0) slips.mean_m /= stances;
  return slips;
}

double Turn(const MotionClip& clip) {
  double turn = 0;
  for (int f = 1; f < clip.frame_count(); ++f) turn += std::remainder(HeadingRad(clip, f) - HeadingRad(clip, f - 1), 2 * M_PI);
  return turn;
}

double LeastBend(const MotionClip& clip) {
  double least = 10;
  for (const Foot foot : {Foot::kLeft, Foot::kRight}) {
    const LegIk leg(clip.skeleton(), foot);
    for (int f = 0; f < clip.frame_count(); ++f) {
      least = std::min(least, leg.Measure(clip.root_positions().col(f), clip.rotations(f)).knee_bend_rad);
    }
  }
  return least;
}

double HardestAcceleration(const MotionClip& clip) {
  const auto positions = JointPositions(clip);
  double hardest = 0;
  for (int f = 1; f + 1 < clip.frame_count(); ++f) {
    const Eigen::Matrix3Xd a = positions[f + 1] - 2 * positions[f] + positions[f - 1];
    hardest = std::max(hardest, a.colwise().norm().maxCoeff() * clip.frame_rate_hz() * clip.frame_rate_hz());
  }
  return hardest;
}

MotionClip TwelveSteps() {
  SyntheticGaitOptions options;
  options.steps = 12;
  return GenerateGait(options);
}

TEST(Bend, KeepsPlantedFeetPlantedWhileTheWalkTurns) {
  const MotionClip walk = TwelveSteps();
  const ContactTrack contacts = DetectContacts(walk);
  ASSERT_GT(contacts.intervals.size(), 8u);
  for (const double turn : {-0.35, 0.15, 0.35}) {
    const MotionClip bent = Bent(walk, contacts, {turn});
    EXPECT_LT(PlantedSlips(bent, walk, contacts).worst_m, 1e-3) << turn;
    EXPECT_GT(LeastBend(bent), 0) << turn;
    // 12 steps and a closing one; the rate grows and fades over about one step each.
    EXPECT_NEAR(Turn(bent) / turn, 11, 1.5) << turn;
    EXPECT_LT(HardestAcceleration(bent), 1.35 * HardestAcceleration(walk)) << turn;
  }
}

TEST(Bend, NoTurnChangesNothing) {
  const MotionClip walk = TwelveSteps();
  const MotionClip bent = Bent(walk, DetectContacts(walk), {0.0});
  const auto a = JointPositions(walk), b = JointPositions(bent);
  for (int f = 0; f < walk.frame_count(); ++f) ASSERT_LT((a[f] - b[f]).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Bend, DoesNotTurnWhileStanding) {
  const MotionClip walk = TwelveSteps();
  const MotionClip bent = Bent(walk, DetectContacts(walk), {0.3});
  EXPECT_NEAR(HeadingRad(bent, 25), HeadingRad(walk, 25), 1e-3);
  const int last = bent.frame_count() - 1;
  EXPECT_NEAR(HeadingRad(bent, last), HeadingRad(bent, last - 25), 1e-3);
}

TEST(Bend, RefusesATurnThatNobodyWalks) {
  const MotionClip walk = TwelveSteps();
  const ContactTrack contacts = DetectContacts(walk);
  EXPECT_THROW(Bent(walk, contacts, {0.7}), std::invalid_argument);
  EXPECT_THROW(Bent(walk, contacts, {std::nan("")}), std::invalid_argument);
  EXPECT_THROW(Bent(walk.Slice(0, 50), contacts, {0.1}), std::invalid_argument);
}

TEST(Bend, HoldsForRecordings) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const auto data = testing::SharedData();
  for (const auto& file : {data / "cmu/07/07_01.bvh", data / "cmu/08/08_04.bvh", data / "cmu/131/131_01.bvh",
                           data / "bnr/dataset-2/walk/dataset-2_walk_normal_004.bvh"}) {
    const MotionClip walk = LevelFloor(ImportClip(ReadBvhFile(file)));
    const ContactTrack contacts = DetectContacts(walk);
    const double turn = 0.3;
    const MotionClip bent = Bent(walk, contacts, {turn});
    EXPECT_LT(PlantedSlips(bent, walk, contacts).worst_m, 0.004) << file;
    EXPECT_GT(LeastBend(bent), std::min(0.0, LeastBend(walk)) - 0.01) << file;
    EXPECT_LT(HardestAcceleration(bent), 1.3 * HardestAcceleration(walk)) << file;
    EXPECT_GT(Turn(bent) - Turn(walk), 2 * turn) << file;
  }
}

}  // namespace
}  // namespace morphograph
