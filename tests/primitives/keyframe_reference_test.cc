// Contacts and key frames, by feature and learned, against the kinematic reference that comes with the recordings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "datasets/contact_detector.h"
#include "datasets/errors.h"
#include "datasets/synthetic_gait.h"
#include "primitives/keyframe_cues.h"
#include "primitives/keyframe_detector.h"
#include "primitives/learned_keyframes.h"
#include "tests/support/keyframe_splits.h"
#include "tests/support/labelled_clips.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using testing::LabelledClip;

class Reference : public ::testing::TestWithParam<const char*> {};

// Share of (frame, foot) pairs on which both say the same.
double ContactAgreement(const LabelledClip& labelled, const std::vector<ContactInterval>& found) {
  const int frames = labelled.clip.frame_count();
  const auto flags = [frames](const std::vector<ContactInterval>& intervals) {
    Eigen::ArrayXXi stands = Eigen::ArrayXXi::Zero(2, frames);
    for (const ContactInterval& interval : intervals) {
      for (int f = std::max(0, interval.first); f <= std::min(interval.last, frames - 1); ++f) {
        stands(interval.foot == Foot::kLeft ? 0 : 1, f) = 1;
      }
    }
    return stands;
  };
  return static_cast<double>((flags(labelled.contacts) == flags(found)).count()) / (2.0 * frames);
}

TEST_P(Reference, ContactsAgree) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  for (const LabelledClip& labelled : testing::ReadLabelledClips(testing::SharedData(), GetParam())) {
    EXPECT_GE(ContactAgreement(labelled, DetectContacts(labelled.clip).intervals), 0.98) << labelled.path;
  }
}

TEST_P(Reference, FeatureKeyframesFindTheStrikes) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  KeyframeScore score;
  for (const LabelledClip& labelled : testing::ReadLabelledClips(testing::SharedData(), GetParam())) {
    score += testing::JudgeKeyframes(DetectKeyframes(labelled.clip), labelled);
  }
  EXPECT_GT(score.true_positives, 0);
  EXPECT_GE(score.precision(), 0.97);
  EXPECT_GE(score.extraction_rate(), 0.97);
  EXPECT_LE(score.distortion_s(), 0.025);
}

class LearnedReference : public ::testing::TestWithParam<const char*> {};

TEST_P(LearnedReference, EachHalfOfTheClipsTeachesTheOther) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<LabelledClip> clips = testing::ReadLabelledClips(testing::SharedData(), GetParam());
  const KeyframeScore score = testing::JudgeLearned(clips, testing::AlternateHalves(clips.size()));
  EXPECT_GE(score.precision(), 0.97);
  EXPECT_GE(score.extraction_rate(), 0.97);
  EXPECT_LE(score.distortion_s(), 0.02);
}

TEST_P(LearnedReference, WhateverTheHalvesAre) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<LabelledClip> clips = testing::ReadLabelledClips(testing::SharedData(), GetParam());
  const int splits = clips.size() < 40 ? 8 : 1;  // keyframe_benchmark draws more
  KeyframeScore sum;
  for (int seed = 1; seed <= splits; ++seed) {
    const KeyframeScore score = testing::JudgeLearned(clips, testing::RandomHalves(clips.size(), static_cast<std::uint64_t>(seed)));
    // Of cmu's three subjects one walked twice, with a ball and from and to a stand: the half without these two clips has not seen such.
    EXPECT_GE(score.precision(), 0.95) << seed;
    EXPECT_GE(score.extraction_rate(), 0.95) << seed;
    sum += score;
  }
  EXPECT_GE(sum.precision(), 0.97);
  EXPECT_GE(sum.extraction_rate(), 0.97);
}

// Subjects of cmu, styles of bnr.
TEST_P(LearnedReference, TheOthersTeachWhatOneSubjectOrStyleDoes) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<LabelledClip> clips = testing::ReadLabelledClips(testing::SharedData(), GetParam());
  const std::vector<testing::KeyframeFold> folds = testing::LeaveGroupsOut(clips);
  ASSERT_EQ(folds.size(), GetParam() == std::string("cmu") ? 3u : 6u);
  const KeyframeScore score = testing::JudgeLearned(clips, folds);
  EXPECT_GE(score.precision(), 0.97);
  EXPECT_GE(score.extraction_rate(), 0.97);
}

INSTANTIATE_TEST_SUITE_P(Sets, LearnedReference, ::testing::Values("cmu", "bnr"),
                         [](const auto& suite) { return std::string(suite.param); });

TEST(LearnedKeyframes, ExamplesOfOneCaptureServeAnother) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<LabelledClip> taught = testing::ReadLabelledClips(testing::SharedData(), "bnr");
  std::vector<KeyframeExamples> examples;
  for (size_t i = 0; i < taught.size(); i += 4) examples.push_back(testing::StrikeExamples(taught[i]));
  const LearnedKeyframeDetector detector(examples);
  KeyframeScore score;
  for (const LabelledClip& clip : testing::ReadLabelledClips(testing::SharedData(), "cmu")) {
    score += testing::JudgeKeyframes(WalkingKeyframes(detector.Detect(clip.clip)), clip);
  }
  EXPECT_GE(score.precision(), 0.93);
  EXPECT_GE(score.extraction_rate(), 0.93);
}

TEST(LearnedKeyframes, OneSideTeachesTheOtherInTheMirrorAndSlowWalksAreNotEarly) {
  SyntheticGaitOptions options;
  options.speed_m_s = 1.5;
  options.steps = 10;
  const auto labels = [](const SyntheticGaitOptions& made, const SyntheticGaitTruth& truth) {
    std::vector<LabelledFrame> frames;
    for (const SyntheticGaitTruth::Strike& strike : truth.strikes) {
      frames.push_back({static_cast<int>(std::lround(strike.time_s * made.frame_rate_hz)),
                        strike.foot == Foot::kLeft ? "left_strike" : "right_strike"});
    }
    return frames;
  };
  SyntheticGaitTruth truth;
  const MotionClip taught = GenerateGait(options, &truth);
  std::vector<LabelledFrame> marked = labels(options, truth);
  // Of the right side a single example in the middle of the walk: it names the side, the mirror does the rest.
  const auto right = std::find_if(marked.begin() + 4, marked.end(), [](const auto& frame) { return frame.label == "right_strike"; });
  ASSERT_NE(right, marked.end());
  const LabelledFrame kept = *right;
  std::erase_if(marked, [](const LabelledFrame& frame) { return frame.label == "right_strike"; });
  marked.push_back(kept);
  std::sort(marked.begin(), marked.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
  const LearnedKeyframeDetector detector({{&taught, marked}});

  options.speed_m_s = 1.0;
  const MotionClip slow = GenerateGait(options, &truth);
  int found = 0, judged = 0;
  const std::vector<LearnedKeyframe> keyframes = detector.Detect(slow);
  const std::vector<LabelledFrame> wanted = labels(options, truth);
  for (size_t i = 2; i + 2 < wanted.size(); ++i) {  // the steady middle
    ++judged;
    found += std::any_of(keyframes.begin(), keyframes.end(), [&](const LearnedKeyframe& keyframe) {
      return keyframe.label == wanted[i].label && std::abs(keyframe.frame - wanted[i].frame) <= 0.05 * options.frame_rate_hz;
    });
  }
  EXPECT_GE(judged, 5);
  EXPECT_EQ(found, judged);
}

TEST(TimingCues, FindTheOffsetAndPreferTheSteadySignal) {
  // Row 0 peaks 4 frames before every label, row 1 at places that have nothing to do with them.
  const double rate = 100;
  Eigen::MatrixXd signals(2, 400);
  std::vector<double> frames;
  for (int f = 0; f < 400; ++f) {
    signals(0, f) = std::cos(2 * 3.14159265358979 * (f - 46) / 100.0);
    signals(1, f) = std::cos(2 * 3.14159265358979 * (f - 10) / 37.0);
  }
  for (int f = 50; f < 400; f += 100) frames.push_back(f);
  const std::vector<TimingCue> cues = LearnTimingCues({{&signals, rate, frames}}, 0.15, 1);
  ASSERT_EQ(cues.size(), 1u);
  EXPECT_EQ(cues[0].signal, 0);
  EXPECT_TRUE(cues[0].maximum);
  EXPECT_NEAR(cues[0].offset_s, 0.04, 1e-3);
  EXPECT_NEAR(RefineByCues(cues, signals, rate, 140, 0.15).value(), 150, 0.1);
  EXPECT_FALSE(RefineByCues(cues, signals, rate, 200, 0.15).has_value());  // no turning point near
}

TEST(KeyframeLabels, SaysWhatIsWrong) {
  EXPECT_EQ(ParseKeyframeLabels(R"([{"frame": 9, "label": "b"}, {"frame": 3, "label": "a"}])", "x").at("")[0].label, "a");
  EXPECT_EQ(ParseKeyframeLabels(R"({"clip": [{"frame": 3, "label": "left_strike", "doubtful": true}]})", "x").at("clip").size(), 1u);
  for (const char* bad : {"", "{", "3", "{\"a\": 3}", "[{\"frame\": -1, \"label\": \"a\"}]", "[{\"frame\": 1e99, \"label\": \"a\"}]",
                          "[{\"frame\": 1}]", "[{\"frame\": 1, \"label\": 2}]", "[[[[[[[[[[[[[[]]]]]]]]]]]]]]"}) {
    EXPECT_THROW(ParseKeyframeLabels(bad, "x"), DatasetError) << bad;
  }
}

TEST(KeyframeEvaluation, MatchesOneToOne) {
  const auto left = KeyframeLabel::kLeftStance, right = KeyframeLabel::kRightStance;
  const std::vector<ReferenceKeyframe> reference = {{10, 10, 14, left}, {30, 30, 30, right}, {50, 50, 50, left, true}};
  const KeyframeScore score =
      EvaluateKeyframes({{12, left}, {13, left}, {31, left}, {50, left}}, reference, {left, right}, 30, 2.0 / 30);
  EXPECT_EQ(score.true_positives, 1);   // 12; 13 would match the same one again
  EXPECT_EQ(score.false_positives, 2);  // 13, and 31, which has the wrong side; 50 is doubtful and does not count
  EXPECT_EQ(score.false_negatives, 1);  // the right one
  EXPECT_NEAR(score.distortion_s(), 2.0 / 30, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Sets, Reference, ::testing::Values("cmu", "bnr", "neura_s02"),
                         [](const auto& suite) { return std::string(suite.param); });

}  // namespace
}  // namespace morphograph
