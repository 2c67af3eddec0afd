#include "synthesis/variant_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "datasets/virtual_sensors.h"
#include "synthesis/joint_spread.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/sensors/motion_source.h"
#include "tests/support/small_model.h"
#include "tests/synthesis/gait_clips.h"

namespace morphograph {
namespace {

SynthesisRequest SixSteps(std::uint64_t seed) {
  SynthesisRequest request;
  request.seed = seed;
  request.steps = 6;
  request.style = "brisk";
  return request;
}

VariantOptions Of(int count, int threads) {
  VariantOptions options;
  options.count = count;
  options.threads = threads;
  return options;
}

void ExpectSame(const VariantSet& a, const VariantSet& b) {
  ASSERT_EQ(a.variants.size(), b.variants.size());
  for (std::size_t i = 0; i < a.variants.size(); ++i) {
    EXPECT_EQ(a.variants[i].index, b.variants[i].index);
    EXPECT_EQ(a.variants[i].clip.root_positions(), b.variants[i].clip.root_positions());
  }
  EXPECT_EQ(a.summary.clip_spread_m, b.summary.clip_spread_m);
  EXPECT_EQ(a.summary.step_spread_m, b.summary.step_spread_m);
  EXPECT_EQ(a.summary.swept_area.area_m2, b.summary.swept_area.area_m2);
  ASSERT_EQ(a.summary.swept_area.regions.size(), b.summary.swept_area.regions.size());
  EXPECT_EQ(a.summary.swept_area.regions[0].outline_m, b.summary.swept_area.regions[0].outline_m);
}

// Readings are made ready once, and while others let it work.
TEST(VariantSet, MakesReadingsReadyInItsTurn) {
  const auto model = testing::SmallModelWithRecordings();
  const std::vector<Placement> sensors = PlacementsAtJoints({"left_ankle", "right_ankle"});
  SynthesisRequest request = SixSteps(1);
  request.control.sensors = SensorTerm{VirtualAccelerations(Synthesize(*model, request).clip, sensors, 30), sensors};
  request.steps.reset();
  VariantOptions options = Of(3, 1);
  int turns = 0, made = 0;
  options.begin = [&](int) { return ++turns > 0; };
  options.end = [&](int) { --turns; };
  options.sensor_steps = [&](const std::vector<Placement>& placements) {
    ++made;
    EXPECT_EQ(turns, 1);
    const MotionSource source = SourceOf(*model);
    return std::make_shared<const SensorSteps>(source.clips, source.steps, model->layout(), placements);
  };
  EXPECT_EQ(MakeVariants(*model, request, options).variants.size(), 3u);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(turns, 0);
}

TEST(VariantSet, HoldsTheClipOfEachSeedRankedByLikelihood) {
  const auto model = testing::SmallModel();
  const VariantSet set = MakeVariants(*model, SixSteps(~std::uint64_t{0} - 3), Of(12, 2));
  ASSERT_EQ(set.variants.size(), 12u);
  std::vector<bool> seen(12);
  for (const ClipVariant& variant : set.variants) {
    seen.at(static_cast<std::size_t>(variant.index)) = true;
    const std::uint64_t seed = ~std::uint64_t{0} - 3 + static_cast<std::uint64_t>(variant.index);  // goes on at 0
    EXPECT_EQ(variant.report.seed, seed);
    EXPECT_EQ(variant.clip.root_positions(), Synthesize(*model, SixSteps(seed)).clip.root_positions());
    EXPECT_NEAR(variant.log_likelihood_per_step, *variant.report.quality.log_likelihood / static_cast<double>(variant.report.steps.size()), 1e-12);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 12);
  for (std::size_t i = 1; i < set.variants.size(); ++i)
    EXPECT_GE(set.variants[i - 1].log_likelihood_per_step, set.variants[i].log_likelihood_per_step);
  EXPECT_GT(set.variants.front().log_likelihood_per_step, set.variants.back().log_likelihood_per_step);
  EXPECT_EQ(set.summary.asked, 12);
  EXPECT_EQ(set.summary.made, 12);
  EXPECT_LE(set.summary.duration_s.min, set.summary.duration_s.mean);
  EXPECT_LE(set.summary.duration_s.mean, set.summary.duration_s.max);
  EXPECT_FALSE(set.summary.arrival_s || set.summary.path_deviation_mean_m);  // nothing of that was asked for
  EXPECT_GT(set.summary.step_spread_m, 0.005);
  EXPECT_GT(set.summary.clip_spread_m, set.summary.step_spread_m);  // ways part
  EXPECT_GT(set.summary.swept_area.area_m2, 1);
}

TEST(VariantSet, DoesNotDependOnTheNumberOfThreads) {
  const auto model = testing::SmallModel();
  const VariantSet alone = MakeVariants(*model, SixSteps(5), Of(40, 1));
  ExpectSame(alone, MakeVariants(*model, SixSteps(5), Of(40, 3)));
  std::atomic<int> turns = 0;
  VariantOptions in_turns = Of(40, 3);
  in_turns.begin = [&](int) { return ++turns > 0; };
  in_turns.end = [&](int) { --turns; };
  ExpectSame(alone, MakeVariants(*model, SixSteps(5), in_turns));
  EXPECT_EQ(turns, 0);
}

TEST(VariantSet, StopsWhenItIsToldTo) {
  const auto model = testing::SmallModel();
  std::atomic<int> begun = 0, ended = 0;
  VariantOptions options = Of(1000, 2);
  options.begin = [&](int) { return ++begun < 10; };
  options.end = [&](int) { ++ended; };
  EXPECT_THROW(MakeVariants(*model, SixSteps(5), options), VariantsCancelled);
  EXPECT_LT(begun, 15);
  EXPECT_EQ(ended, 9);
}

TEST(VariantSet, RefusesMoreThanFitsInMemory) {
  const auto model = testing::SmallModel();
  std::atomic<int> tried = 0;
  VariantOptions options = Of(40, 2);
  options.begin = [&](int) { return ++tried > 0; };
  options.max_joint_frames = 20'000;  // a fifth of them or so
  EXPECT_THROW(MakeVariants(*model, SixSteps(5), options), VariantsTooLarge);
  EXPECT_LE(tried, 16);
  tried = 0;
  const VariantSet all = MakeVariants(*model, SixSteps(5), Of(40, 2));
  options.max_joint_frames = 0;
  for (const ClipVariant& variant : all.variants) options.max_joint_frames += std::int64_t{variant.clip.frame_count()} * variant.clip.joint_count();
  EXPECT_EQ(MakeVariants(*model, SixSteps(5), options).variants.size(), 40u);
  --options.max_joint_frames;
  EXPECT_THROW(MakeVariants(*model, SixSteps(5), options), VariantsTooLarge);
}

TEST(VariantSet, WhereNoneCanBeMetTheFirstOnesReasonIsTold) {
  SynthesisRequest request = SixSteps(1);
  request.style = "moonwalk";
  std::atomic<int> tried = 0;
  VariantOptions options = Of(1000, 2);
  options.begin = [&](int) { return ++tried > 0; };
  try {
    MakeVariants(*testing::SmallModel(), request, options);
    ADD_FAILURE() << "was made";
  } catch (const UnsatisfiableRequest& unmet) {
    EXPECT_EQ(unmet.pointer(), "/style");
  }
  EXPECT_EQ(tried, 16);
}

// A clip whose root stands at the given places, a frame each.
ClipVariant Standing(const std::vector<Eigen::Vector2d>& places, double rate_hz) {
  ClipVariant variant;
  const MotionClip walk = testing::GaitClip(3);
  variant.clip = MotionClip(walk.shared_skeleton(), rate_hz, static_cast<int>(places.size()));
  for (std::size_t f = 0; f < places.size(); ++f)
    variant.clip.root_positions().col(static_cast<Eigen::Index>(f)) = Eigen::Vector3d(places[f].x(), 1, places[f].y());
  variant.report.path_m = places;
  return variant;
}

TEST(VariantSummary, MeasuresArrivalAndDeviation) {
  SynthesisRequest request;
  request.control.path.emplace().points_m = {{0, 0}, {2, 0}, {2, 2}};
  request.control.goal.emplace().position_m = {2, 2};
  request.control.goal->tolerance_m = 0.05;
  // Passes the goal, comes back, and stays from frame 4 on; then one that is there late.
  const std::vector<ClipVariant> variants = {Standing({{0, 0}, {2, 2}, {2, 1}, {2, 0.3}, {2, 2.04}, {2, 1.99}}, 10),
                                             Standing({{0, 0.2}, {1, 0}, {2, 0}, {2, 1}, {2, 1.5}, {2, 1.96}}, 10)};
  const VariantSummary summary = SummariseVariants(request, 3, variants, 0.2, 1);
  EXPECT_EQ(summary.asked, 3);
  EXPECT_EQ(summary.made, 2);
  EXPECT_NEAR(summary.arrival_s->min, 0.4, 1e-12);
  EXPECT_NEAR(summary.arrival_s->max, 0.5, 1e-12);
  EXPECT_NEAR(summary.arrival_s->mean, 0.45, 1e-12);
  EXPECT_NEAR(summary.duration_s.mean, 0.5, 1e-12);
  EXPECT_NEAR(*summary.path_deviation_max_m, 0.2, 1e-12);
  EXPECT_NEAR(*summary.path_deviation_mean_m, (0.2 + 0.04) / 12, 1e-12);
  request.control.goal.reset();
  request.control.path->tolerance_m = 1.1;  // of the path's end
  EXPECT_NEAR(SummariseVariants(request, 3, variants, 0.2, 1).arrival_s->max, 0.4, 1e-12);
}

TEST(JointSpread, IsTheMeanDistanceOfAllPairs) {
  const ClipVariant at_0 = Standing({{0, 0}, {0, 0}, {0, 0}}, 10), at_3 = Standing({{3, 0}, {3, 0}, {3, 0}}, 10);
  const ClipVariant at_4 = Standing({{0, 4}, {0, 4}, {0, 4}}, 10);
  const auto samples = [](const ClipVariant& variant, SampleFrame frame) { return SampleJoints(variant.clip, 0, 2, 5, frame); };
  EXPECT_NEAR(MeanPairwiseJointDistance({samples(at_0, SampleFrame::kWorld), samples(at_3, SampleFrame::kWorld), samples(at_4, SampleFrame::kWorld)}),
              (3 + 4 + 5) / 3.0, 1e-5);
  EXPECT_NEAR(MeanPairwiseJointDistance({samples(at_0, SampleFrame::kBody), samples(at_3, SampleFrame::kBody)}), 0, 1e-5);
  EXPECT_EQ(MeanPairwiseJointDistance({}), 0);
}

TEST(JointSpread, TheBodysFrameForgetsWhereAndWhither) {
  const MotionClip walk = testing::GaitClip(3), moved = Moved(walk, 1.2, 5, -3);
  const auto body = [](const MotionClip& clip) { return SampleJoints(clip, 10, 29, 7, SampleFrame::kBody); };
  EXPECT_NEAR(MeanPairwiseJointDistance({body(walk), body(moved)}), 0, 1e-5);
  EXPECT_GT(MeanPairwiseJointDistance({body(walk), SampleJoints(walk, 15, 34, 7, SampleFrame::kBody)}), 0.02);
}

TEST(JointSpread, FallsBetweenFrames) {
  const ClipVariant walk = Standing({{0, 0}, {1, 0}}, 10);
  const JointSamples samples = SampleJoints(walk.clip, 0, 1, 5, SampleFrame::kWorld);
  const Eigen::Index joints = samples.cols() / 5;
  for (int p = 0; p < 5; ++p) EXPECT_NEAR(samples(0, p * joints) - samples(0, 0), p / 4.0, 1e-6);
  EXPECT_THROW(SampleJoints(walk.clip, 0, 2, 5, SampleFrame::kWorld), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
