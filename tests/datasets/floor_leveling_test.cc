#include "datasets/floor_leveling.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/forward_kinematics.h"
#include "datasets/resample.h"
#include "datasets/synthetic_gait.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

MotionClip Tilted(const MotionClip& clip, const Quaterniond& turn, double shift_m) {
  MotionClip tilted = clip;
  for (int f = 0; f < clip.frame_count(); ++f) {
    tilted.rotation(f, clip.skeleton().moving_root()) = turn * clip.rotation(f, clip.skeleton().moving_root());
    tilted.root_positions().col(f) = turn * clip.root_positions().col(f) + Vector3d(0, shift_m, 0);
  }
  return tilted;
}

/// Lowest and highest of the stances' median ball heights while the foot lies flat.
std::pair<double, double> StanceHeights(const MotionClip& clip) {
  const ContactTrack contacts = DetectContacts(clip);
  double low = 10, high = -10;
  for (const ContactInterval& interval : contacts.intervals) {
    const int side = interval.foot == Foot::kLeft ? 0 : 1;
    std::vector<double> heights;
    for (int f = interval.first; f <= interval.last; ++f) {
      if (contacts.planted(2 * side, f) && contacts.planted(2 * side + 1, f)) heights.push_back(contacts.balls[side](1, f));
    }
    if (heights.size() < 0.15 * clip.frame_rate_hz()) continue;
    std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2), heights.end());
    low = std::min(low, heights[heights.size() / 2]);
    high = std::max(high, heights[heights.size() / 2]);
  }
  return {low, high};
}

TEST(FloorLeveling, TakesOutAKnownTiltAndShift) {
  SyntheticGaitOptions options;
  options.turns_rad = {0.3};  // covers the floor in both directions
  const MotionClip walk = GenerateGait(options);
  const Quaterniond turn(Eigen::AngleAxisd(0.05, Vector3d(1, 0, 0.6).normalized()));
  FloorLevelingReport report;
  const MotionClip level = LevelFloor(Tilted(walk, turn, -0.3), {}, &report);
  EXPECT_GT(report.slope.norm(), 0.04);
  EXPECT_GT(report.shift_m, 0.2);
  const auto [low, high] = StanceHeights(level);
  EXPECT_LT(high - low, 0.004);
  EXPECT_NEAR(low, FloorLevelingOptions().ball_height_m, 0.012);
}

TEST(FloorLeveling, LeavesALevelFloorAlone) {
  const MotionClip walk = GenerateGait({});
  FloorLevelingReport report;
  const MotionClip level = LevelFloor(walk, {}, &report);
  EXPECT_EQ(level.root_positions(), walk.root_positions());
  EXPECT_EQ(report.slope.norm(), 0);
  EXPECT_EQ(report.shift_m, 0);
}

TEST(FloorLeveling, RefusesAClipWithoutFrames) {
  const MotionClip walk = GenerateGait({});
  EXPECT_THROW(LevelFloor(walk.Slice(0, 0), ContactTrack()), std::invalid_argument);
}

TEST(FloorLeveling, FlattensTheStancesOfRecordings) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const auto data = testing::SharedData();
  // What a plane leaves: left and right feet of one person differ, and the styled walk of 131 never puts its feet quite flat.
  const std::pair<const char*, double> spreads[] = {{"cmu/07/07_01.bvh", 0.010}, {"cmu/07/07_05.bvh", 0.010},
                                                    {"cmu/07/07_11.bvh", 0.010}, {"cmu/08/08_01.bvh", 0.016},
                                                    {"cmu/08/08_08.bvh", 0.016}, {"cmu/131/131_01.bvh", 0.025}};
  for (const auto& [name, spread] : spreads) {
    const MotionClip clip = Resample(ImportClip(ReadBvhFile(data / name)), 60);
    const auto [low, high] = StanceHeights(LevelFloor(clip));
    EXPECT_LT(high - low, spread) << name;
    EXPECT_NEAR((low + high) / 2, FloorLevelingOptions().ball_height_m, 0.02) << name;
  }
  FloorLevelingReport report;
  const MotionClip flat = ImportClip(ReadBvhFile(data / "bnr/dataset-2/walk/dataset-2_walk_normal_004.bvh"));
  LevelFloor(flat, {}, &report);
  EXPECT_EQ(report.slope.norm(), 0);
  EXPECT_EQ(report.shift_m, 0);
}

}  // namespace
}  // namespace morphograph
