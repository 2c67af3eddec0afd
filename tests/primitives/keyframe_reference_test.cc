// Contacts and feature-based key frames against the kinematic reference that comes with the recordings.
#include <gtest/gtest.h>

#include "datasets/contact_detector.h"
#include "datasets/errors.h"
#include "primitives/keyframe_detector.h"
#include "primitives/learned_keyframes.h"
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
    const double rate = labelled.clip.frame_rate_hz();
    score += EvaluateKeyframes(DetectKeyframes(labelled.clip), labelled.reference, testing::StanceLabels(), rate,
                               testing::StrikeToleranceS(rate));
  }
  EXPECT_GT(score.true_positives, 0);
  EXPECT_GE(score.precision(), 0.97);
  EXPECT_GE(score.extraction_rate(), 0.97);
  EXPECT_LE(score.distortion_s(), 0.025);
}

TEST(LearnedReference, HalfOfTheClipsTeachTheOtherHalf) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<LabelledClip> clips = testing::ReadLabelledClips(testing::SharedData(), "bnr");
  std::vector<KeyframeExamples> examples;
  for (size_t i = 0; i < clips.size(); i += 2) examples.push_back({&clips[i].clip, clips[i].labels});
  const LearnedKeyframeDetector detector(examples);
  KeyframeScore score;
  for (size_t i = 1; i < clips.size(); i += 2) {
    score += EvaluateKeyframes(WalkingKeyframes(detector.Detect(clips[i].clip)), clips[i].reference,
                               testing::StanceLabels(), 30, testing::StrikeToleranceS(30));
  }
  EXPECT_GE(score.precision(), 0.97);
  EXPECT_GE(score.extraction_rate(), 0.97);
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
