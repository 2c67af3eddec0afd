// The parts of the study that measure one stage of learning each: that they run on any set of clips, and that what must hold of any data
// holds in them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "api/study/alignment_study.h"
#include "api/study/keyframe_study.h"
#include "api/study/mixture_study.h"
#include "api/study/reduction_study.h"
#include "datasets/errors.h"
#include "tests/support/small_study.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::SmallContext;

double Value(const StudySection& section, const std::string& part) {
  for (const StudyFigure& figure : section.figures) {
    if (figure.what.find(part) != std::string::npos && figure.value) return *figure.value;
  }
  ADD_FAILURE() << "no figure for " << part;
  return std::nan("");
}

// Sound, and every point of its charts has a place.
void ExpectDrawn(const StudySection& section) {
  testing::ExpectSound(section);
  EXPECT_FALSE(section.drawings.empty());
  for (const auto& drawing : section.drawings) {
    const Chart* chart = std::get_if<Chart>(&drawing);
    for (const ChartSeries& series : chart ? chart->series : std::vector<ChartSeries>{}) {
      for (const double y : series.y) EXPECT_TRUE(std::isfinite(y)) << chart->title;
    }
  }
}

TEST(StudyMeasures, AlignmentIsNearerWithWeightsAndFurtherWithNoise) {
  StudyContext context = SmallContext(12);
  const StudySection section = StudyAlignment(context);
  ExpectDrawn(section);
  const auto difference = [&](const char* data, const char* way) { return section.data[data]["mean"][way]["path_difference_m"].get<double>(); };
  for (const char* data : {"clean", "noisy"}) {
    // The steeper the weights, the more of them lies on the root, and the nearer it must come.
    EXPECT_LT(difference(data, "depth_power_1"), difference(data, "unweighted"));
    EXPECT_LT(difference(data, "depth_power_4"), difference(data, "depth_power_2"));
    EXPECT_GT(difference(data, "depth_power_4"), 0);
  }
  EXPECT_GT(difference("noisy", "unweighted"), difference("clean", "unweighted"));
  EXPECT_GT(section.data["noisy"]["mean"]["depth_power_1"]["speed_variance_m2_s2"].get<double>(),
            section.data["clean"]["mean"]["depth_power_1"]["speed_variance_m2_s2"].get<double>());
  EXPECT_NEAR(Value(section, "weighted / unweighted, noisy"), difference("noisy", "depth_power_1") / difference("noisy", "unweighted"), 1e-12);
}

TEST(StudyMeasures, KeyframesWithoutLabelsAreHeldAgainstTheCleanClips) {
  StudyContext context = SmallContext(12);
  const StudySection section = StudyKeyframes(context);
  ExpectDrawn(section);
  EXPECT_THAT(section.text, HasSubstr("No clip of these data is labelled"));
  EXPECT_EQ(Value(section, "by feature, clean: precision"), 1);
  EXPECT_EQ(Value(section, "by feature, clean: extraction rate"), 1);
  EXPECT_GT(Value(section, "by feature, noisy: distortion"), Value(section, "by feature, clean: distortion"));
  EXPECT_GT(Value(section, "learned, clean: extraction rate"), 0.8);
  // Steps that are shorter than the least step time are lost.
  const auto& by_step = section.data["clean"]["by_feature"];
  EXPECT_LT(by_step.back()["extraction_rate"].get<double>(), by_step.front()["extraction_rate"].get<double>());
}

TEST(StudyMeasures, KeyframesAreHeldAgainstLabelsWhereThereAreSome) {
  StudyContext unlabelled = SmallContext(2);
  LabelledClips labels;
  labels[unlabelled.loaded()[0].file.stem().string()] = {{40, "left_strike", false}, {41, "hop", false}};
  StudyContext context = SmallContext(2, 2, labels);
  const StudySection section = StudyKeyframes(context);
  EXPECT_THAT(section.text, Not(HasSubstr("No clip of these data is labelled")));
  EXPECT_THAT(section.text, HasSubstr("cannot be both taught and judged"));
  EXPECT_TRUE(section.data["labelled"].get<bool>());
  EXPECT_LT(Value(section, "by feature, clean: precision"), 0.5);  // one label for a whole walk: the rest is wrong
}

TEST(StudyMeasures, WeightedComponentsLeaveTheLeastWeightedErrorOnWhatTheyWereTaught) {
  StudyContext context = SmallContext(12);
  const StudySection section = StudyReduction(context);
  ExpectDrawn(section);
  for (const char* data : {"clean", "noisy"}) {
    ASSERT_TRUE(section.data.contains(data)) << section.text;
    const auto& of = section.data[data];
    const auto weighted = of["weighted_pca"]["error_taught_m2"].get<std::vector<double>>();
    const auto plain = of["plain_pca"]["error_taught_m2"].get<std::vector<double>>();
    const auto left_out = of["weighted_pca"]["error_left_out_m2"].get<std::vector<double>>();
    const auto kept = of["weighted_pca"]["variance_kept"].get<std::vector<double>>();
    for (size_t k = 0; k < weighted.size(); ++k) {
      EXPECT_LE(weighted[k], plain[k] + 1e-9 * weighted[0]) << k;
      EXPECT_LE(weighted[k], weighted[k > 0 ? k - 1 : 0]);
      EXPECT_NEAR(weighted[k] / weighted[0], 1 - kept[k], 0.35) << k;  // means of ratios over classes differ from ratios of means
    }
    EXPECT_LT(weighted.back(), 1e-9 * weighted.front());  // all components: nothing is lost of what was taught
    EXPECT_GT(left_out.back(), 1e-3 * left_out.front());
    EXPECT_GT(of["lle"]["error_left_out_m2"].front().get<double>(), 0);
  }
  EXPECT_GT(section.data["noisy"]["weighted_pca"]["error_taught_m2"][8].get<double>(),
            section.data["clean"]["weighted_pca"]["error_taught_m2"][8].get<double>());
}

TEST(StudyMeasures, MixtureTablesCoverEveryFormAndNumber) {
  StudyContext context = SmallContext(12);
  const StudySection section = StudyMixture(context);
  ExpectDrawn(section);
  for (const char* form : {"full", "tied", "diagonal"}) {
    EXPECT_EQ(section.data["clean"]["bic_per_step_weighted"][form].size(), 3);
    EXPECT_EQ(section.data["clean"]["bic_per_step_plain"][form].size(), 3);
  }
  // One Gaussian of full size is one that all share.
  EXPECT_NEAR(section.data["clean"]["bic_per_step_weighted"]["full"][0].get<double>(),
              section.data["clean"]["bic_per_step_weighted"]["tied"][0].get<double>(), 1e-9);
  const double best = Value(section, "Gaussians of the least BIC, weighted PCA, clean");
  EXPECT_GE(best, 1);
  EXPECT_LE(best, 3);
}

// Too few clips to say much: a reason, no crash.
TEST(StudyMeasures, TwoClipsAreEnoughToSaySo) {
  for (const auto& part : {StudyAlignment, StudyReduction, StudyMixture}) {
    StudyContext context = SmallContext(2);
    try {
      EXPECT_FALSE(part(context).text.empty());
    } catch (const DatasetError& unfit) {
      EXPECT_THAT(unfit.what(), HasSubstr("steps"));
    }
  }
}

TEST(StudyMeasures, FiguresDoNotDependOnTheNumberOfThreads) {
  StudyContext one = SmallContext(8, 1), three = SmallContext(8, 3);
  EXPECT_EQ(StudyAlignment(one).data.dump(), StudyAlignment(three).data.dump());
  EXPECT_EQ(StudyMixture(one).data.dump(), StudyMixture(three).data.dump());
}

}  // namespace
}  // namespace morphograph
