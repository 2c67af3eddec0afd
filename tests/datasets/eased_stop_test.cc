#include "datasets/eased_stop.h"

#include <gtest/gtest.h>

#include "datasets/augmentation.h"
#include "datasets/dataset_loader.h"
#include "datasets/synthetic_gait.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

// A walk that is cut at a frame and holds that pose.
MotionClip Held(int at, int frames) {
  SyntheticGaitOptions options;
  options.steps = 14;
  options.start_standing = options.stop_standing = false;
  const MotionClip walk = GenerateGait(options);
  MotionClip held = walk.Slice(0, at + frames);
  for (int f = at; f < held.frame_count(); ++f) {
    held.root_positions().col(f) = walk.root_positions().col(at);
    for (int j = 0; j < held.joint_count(); ++j) held.rotation(f, j) = walk.rotation(at, j);
  }
  return held;
}

double Speed(const MotionClip& clip, int f) {
  return (clip.root_positions().col(f + 1) - clip.root_positions().col(f)).norm() * clip.frame_rate_hz();
}

TEST(EasedStop, FindsAPoseThatIsHeldInTheMidstOfAWalk) {
  EXPECT_EQ(FindHold(Held(300, 60)), 300);
  EXPECT_FALSE(FindHold(Held(300, 10))) << "too short to be told from chance";
  EXPECT_FALSE(FindHold(GenerateGait({}))) << "a walk that comes to rest by itself";
  EXPECT_FALSE(FindHold(Held(300, 60).Slice(310, 40))) << "nothing but standing";
}

TEST(EasedStop, ComesToRestInTheHeldPoseWithoutAJump) {
  const MotionClip held = Held(300, 60), stop = EasedStop(held, 300);
  const int last = stop.frame_count() - 1;
  EXPECT_EQ(stop.root_positions().col(last), held.root_positions().col(300));
  EXPECT_LT(stop.rotation(last, 3).angularDistance(held.rotation(300, 3)), 1e-7);
  double fastest_change = 0;
  for (int f = 0; f + 2 < stop.frame_count(); ++f) fastest_change = std::max(fastest_change, std::abs(Speed(stop, f + 1) - Speed(stop, f)));
  EXPECT_LT(fastest_change * stop.frame_rate_hz(), 5) << "m/s^2; the hold itself brakes within a frame";
  EXPECT_GT(Speed(stop, 10), 0.8);
  EXPECT_LT(Speed(stop, last - static_cast<int>(0.9 * stop.frame_rate_hz())), 1e-9);
  EXPECT_THROW(EasedStop(held, 360), std::invalid_argument);
}

TEST(EasedStop, IsAMadeCopyBesideTheRecording) {
  const std::vector<AugmentedClip> clips = Augment({Held(300, 60)}, {});
  ASSERT_EQ(clips.size(), 2u);
  EXPECT_FALSE(clips[0].made);
  EXPECT_TRUE(clips[1].made);
  EXPECT_EQ(Augment({GenerateGait({})}, {}).size(), 1u);
}

TEST(EasedStop, OneRecordingOfCmuHoldsItsPose) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const Dataset dataset = LoadDataset({testing::SharedData() / "cmu" / "06", testing::SharedData() / "cmu" / "07"});
  int held = 0;
  for (const LoadedClip& loaded : dataset.clips) {
    const std::optional<int> hold = FindHold(loaded.clip);
    held += hold.has_value();
    if (hold) {
      EXPECT_EQ(loaded.clip.name, "06_02");
    }
  }
  EXPECT_EQ(held, 1);
}

}  // namespace
}  // namespace morphograph
