#include "graph/training_steps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Only their styles count here.
std::vector<PreparedClip> ClipsOfStyles(const std::vector<std::string>& styles) {
  std::vector<PreparedClip> clips;
  for (const std::string& style : styles) {
    SyntheticGaitOptions options;
    options.steps = 2;
    options.frame_rate_hz = 30;
    clips.emplace_back().clip = GenerateGait(options);
    clips.back().clip.style = style;
  }
  return clips;
}

TrainingStep Start(int clip, bool slow) {
  TrainingStep step;
  step.clip = clip;
  step.primitive = "left_first_start";
  step.start = slow ? KeyframeLabel::kDoubleStance : KeyframeLabel::kStanding;
  step.end = KeyframeLabel::kLeftStance;
  step.slow_step = slow;
  return step;
}

TEST(SettleSlowSteps, MakesThemStartsWhereNothingStartsOutOfStanding) {
  const std::vector<PreparedClip> clips = ClipsOfStyles({"a"});
  std::vector<TrainingStep> steps = {Start(0, true), Start(0, true), Start(0, false)};
  EXPECT_THAT(SettleSlowSteps(clips, "walk", 2, &steps), IsEmpty());
  EXPECT_EQ(steps[0].primitive, "left_first_start");
  EXPECT_TRUE(steps[0].steady && steps[0].slow_step && steps[1].steady);
  EXPECT_FALSE(steps[2].steady) << "one start out of standing must not be mixed with slow steps";
}

TEST(SettleSlowSteps, GivesThemBackWhereStartsOutOfStandingAreEnough) {
  const std::vector<PreparedClip> clips = ClipsOfStyles({"a"});
  std::vector<TrainingStep> steps = {Start(0, false), Start(0, true), Start(0, true), Start(0, true), Start(0, false)};
  EXPECT_THAT(SettleSlowSteps(clips, "walk", 2, &steps), IsEmpty());
  for (const int i : {1, 2, 3}) {
    EXPECT_EQ(steps[i].primitive, "left_walk");
    EXPECT_EQ(steps[i].start, KeyframeLabel::kRightStance);
    EXPECT_EQ(steps[i].end, KeyframeLabel::kLeftStance);
    EXPECT_FALSE(steps[i].steady) << "slow steps stay out of the steady classes";
  }
  EXPECT_TRUE(steps[0].steady && steps[4].steady);
}

TEST(SettleSlowSteps, SaysOfWhichStyleTheyAreTooFew) {
  const std::vector<PreparedClip> clips = ClipsOfStyles({"few", "many"});
  std::vector<TrainingStep> steps = {Start(0, true), Start(1, true), Start(1, true)};
  EXPECT_THAT(SettleSlowSteps(clips, "walk", 2, &steps), ElementsAre(HasSubstr("left_first_start (few): only 1 examples")));
  EXPECT_EQ(steps[0].primitive, "left_walk");
  EXPECT_FALSE(steps[0].steady);
  EXPECT_EQ(steps[1].primitive, "left_first_start");
}

TEST(WalkingNameOf, IsTheStepThatASlowStartIs) {
  EXPECT_EQ(WalkingNameOf(Start(0, true), "walk"), "left_walk");
  EXPECT_EQ(WalkingNameOf(Start(0, false), "walk"), "left_first_start");
}

}  // namespace
}  // namespace morphograph
