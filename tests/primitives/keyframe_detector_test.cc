#include "primitives/keyframe_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "datasets/synthetic_gait.h"
#include "primitives/keyframe_evaluation.h"
#include "tests/support/labelled_clips.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

constexpr KeyframeLabel kOf[2] = {KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance};

std::vector<Keyframe> Stances(const std::vector<Keyframe>& keyframes) {
  std::vector<Keyframe> stances;
  std::copy_if(keyframes.begin(), keyframes.end(), std::back_inserter(stances), [](const Keyframe& keyframe) {
    return keyframe.label == kOf[0] || keyframe.label == kOf[1];
  });
  return stances;
}

struct Gait {
  const char* name;
  double frame_rate_hz, speed_m_s, turn_rad;
};

class MadeWalks : public ::testing::TestWithParam<Gait> {};

TEST_P(MadeWalks, EveryStrikeIsFoundOnce) {
  SyntheticGaitOptions options;
  options.frame_rate_hz = GetParam().frame_rate_hz;
  options.speed_m_s = GetParam().speed_m_s;
  options.turns_rad = {GetParam().turn_rad};
  options.steps = 9;
  SyntheticGaitTruth truth;
  const MotionClip clip = GenerateGait(options, &truth);
  std::vector<ReferenceKeyframe> reference;
  for (const SyntheticGaitTruth::Strike& strike : truth.strikes) {
    const double frame = strike.time_s * options.frame_rate_hz;
    reference.push_back({frame, frame, frame, strike.foot == Foot::kLeft ? kOf[0] : kOf[1]});
  }
  // The closing step comes down slowly, and its contact shows sooner: by 0.12 s at 0.6 m/s.
  reference.back().first -= 0.1 * options.frame_rate_hz;
  const KeyframeScore score =
      EvaluateKeyframes(DetectKeyframes(clip), reference, {kOf[0], kOf[1]}, options.frame_rate_hz, 0.067);
  EXPECT_EQ(score.false_positives, 0);
  EXPECT_EQ(score.false_negatives, 0);
}

INSTANTIATE_TEST_SUITE_P(Gaits, MadeWalks,
                         ::testing::Values(Gait{"plain30", 30, 1.3, 0}, Gait{"plain100", 100, 1.3, 0},
                                           Gait{"plain120", 120, 1.3, 0}, Gait{"slow30", 30, 0.6, 0},
                                           Gait{"slow120", 120, 0.6, 0}, Gait{"fast30", 30, 1.8, 0},
                                           Gait{"fast120", 120, 1.8, 0}, Gait{"turn30", 30, 1.1, 0.3},
                                           Gait{"turn120", 120, 1.1, -0.3}),
                         [](const auto& suite) { return std::string(suite.param.name); });

TEST(KeyframeDetector, MarksTheStandsAtBothEnds) {
  SyntheticGaitOptions options;
  options.stand_s = 1;
  const MotionClip clip = GenerateGait(options);
  const std::vector<Keyframe> keyframes = DetectKeyframes(clip);
  ASSERT_GE(keyframes.size(), 4u);
  EXPECT_EQ(keyframes.front().label, KeyframeLabel::kStanding);
  EXPECT_EQ(keyframes.front().frame, 0);
  EXPECT_EQ(keyframes[1].label, KeyframeLabel::kStanding);
  EXPECT_NEAR(keyframes[1].frame / options.frame_rate_hz, 1, 0.35);
  EXPECT_EQ(keyframes.back().label, KeyframeLabel::kStanding);
  EXPECT_EQ(keyframes.back().frame, clip.frame_count() - 1);
}

TEST(KeyframeDetector, IgnoresHeadingAndFloorPosition) {
  const MotionClip clip = GenerateGait({});
  const std::vector<Keyframe> here = DetectKeyframes(clip);
  const std::vector<Keyframe> there = DetectKeyframes(Moved(clip, -1.7, 40, -9));
  ASSERT_EQ(here.size(), there.size());
  for (size_t i = 0; i < here.size(); ++i) {
    EXPECT_EQ(here[i].label, there[i].label);
    EXPECT_NEAR(here[i].frame, there[i].frame, 1e-6);
  }
}

TEST(KeyframeDetector, AWalkThatBeginsWithTheOtherFootSwapsSides) {
  SyntheticGaitOptions options;
  options.variation = 0;
  const std::vector<Keyframe> left = Stances(DetectKeyframes(GenerateGait(options)));
  options.left_first = false;
  const std::vector<Keyframe> right = Stances(DetectKeyframes(GenerateGait(options)));
  ASSERT_EQ(left.size(), right.size());
  for (size_t i = 0; i < left.size(); ++i) {
    EXPECT_NE(left[i].label, right[i].label);
    EXPECT_NEAR(left[i].frame, right[i].frame, 1);
  }
}

TEST(KeyframeDetector, DoesNotDependOnTheFrameRate) {
  for (const double speed_m_s : {0.6, 1.0, 1.3, 1.8}) {
    SyntheticGaitOptions options;
    options.speed_m_s = speed_m_s;
    options.frame_rate_hz = 120;
    const std::vector<Keyframe> fast = Stances(DetectKeyframes(GenerateGait(options)));
    EXPECT_EQ(fast.size(), 11u) << "the closing step included";
    for (const double rate_hz : {24.0, 25.0, 30.0, 50.0, 60.0, 100.0, 240.0}) {
      options.frame_rate_hz = rate_hz;
      const std::vector<Keyframe> slow = Stances(DetectKeyframes(GenerateGait(options)));
      ASSERT_EQ(slow.size(), fast.size()) << rate_hz << " Hz, " << speed_m_s << " m/s";
      for (size_t i = 0; i + 1 < slow.size(); ++i) EXPECT_NEAR(slow[i].frame / rate_hz, fast[i].frame / 120, 0.01) << rate_hz;
      // The closing step is taken from the contacts, which are whole frames.
      EXPECT_NEAR(slow.back().frame / rate_hz, fast.back().frame / 120, 1 / std::min(rate_hz, 120.0)) << rate_hz;
    }
  }
}

TEST(KeyframeDetector, FindsNoStepInAStandOrInAFewFrames) {
  const MotionClip clip = GenerateGait({});
  EXPECT_TRUE(DetectKeyframes(clip.Slice(0, 0)).empty());
  EXPECT_TRUE(DetectKeyframes(clip.Slice(0, 1)).empty());
  EXPECT_TRUE(Stances(DetectKeyframes(clip.Slice(0, 30))).empty());
}

TEST(KeyframeDetector, RefusesUnknownActions) {
  EXPECT_THROW(KeyframeOptionsFor("juggle"), std::invalid_argument);
  EXPECT_EQ(KeyframeOptionsFor("run").landing, LandingFeature::kContact);
}

// No parameter is tuned to the labelled clips: each may be off by a fifth.
TEST(KeyframeDetector, HoldsWhenParametersAreOffByAFifth) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<testing::LabelledClip> clips;
  for (const char* set : {"cmu", "bnr"}) {
    for (testing::LabelledClip& clip : testing::ReadLabelledClips(testing::SharedData(), set)) clips.push_back(std::move(clip));
  }
  double KeyframeOptions::* const parameters[] = {
      &KeyframeOptions::low_pass_hz,    &KeyframeOptions::min_step_s,        &KeyframeOptions::min_prominence,
      &KeyframeOptions::min_swing_m,    &KeyframeOptions::rest_ratio,        &KeyframeOptions::landing_delay_s,
      &KeyframeOptions::min_seen_s,     &KeyframeOptions::standing_pelvis_m_s, &KeyframeOptions::standing_foot_m_s,
      &KeyframeOptions::min_standing_s, &KeyframeOptions::max_standing_gap_s};
  for (size_t p = 0; p < std::size(parameters); ++p) {
    for (const double factor : {0.8, 1.2}) {
      KeyframeOptions options;
      options.*parameters[p] *= factor;
      KeyframeScore score;
      for (size_t i = 0; i < clips.size(); i += 2) {
        const double rate = clips[i].clip.frame_rate_hz();
        score += EvaluateKeyframes(DetectKeyframes(clips[i].clip, options), clips[i].reference, testing::StanceLabels(),
                                   rate, testing::StrikeToleranceS(rate));
      }
      EXPECT_GE(score.precision(), 0.97) << "parameter " << p << " x " << factor;
      EXPECT_GE(score.extraction_rate(), 0.97) << "parameter " << p << " x " << factor;
    }
  }
}

}  // namespace
}  // namespace morphograph
