// Contacts and feature-based key frames against the kinematic reference that comes with the recordings.
#include <gtest/gtest.h>

#include "datasets/contact_detector.h"
#include "primitives/keyframe_detector.h"
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

INSTANTIATE_TEST_SUITE_P(Sets, Reference, ::testing::Values("cmu", "bnr", "neura_s02"),
                         [](const auto& suite) { return std::string(suite.param); });

}  // namespace
}  // namespace morphograph
