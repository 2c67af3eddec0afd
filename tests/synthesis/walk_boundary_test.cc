// Clips that start and stop: on models of synthetic walks, out of standing and out of a slow first step.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/forward_kinematics.h"
#include "synthesis/motion_synthesizer.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

SynthesisRequest Whole(std::uint64_t seed) {
  SynthesisRequest request;
  request.seed = seed;
  request.start_from = request.end = WalkBoundary::kStanding;
  return request;
}

// Metres a second of the pelvis over the floor between frames f and f + 1.
double Speed(const MotionClip& clip, int f) {
  const Eigen::Vector3d step = clip.root_positions().col(f + 1) - clip.root_positions().col(f);
  return std::hypot(step.x(), step.z()) * clip.frame_rate_hz();
}

// How far the balls of the feet go over the floor in `frames` frames from `first` on, the further one, metres.
double WayOfFeet(const MotionClip& clip, int first, int frames) {
  const auto positions = JointPositions(clip);
  double way = 0;
  for (const JointRole role : {JointRole::kLeftToe, JointRole::kRightToe}) {
    const int toe = clip.skeleton().roles()[role];
    way = std::max(way, (positions[first + frames].col(toe) - positions[first].col(toe)).norm());
  }
  return way;
}

TEST(WalkBoundary, AWholeWalkComesFromRestAndComesToRest) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SynthesisRequest request = Whole(seed);
    request.duration_s = 7;
    const SynthesisResult result = Synthesize(*testing::SmallModel(), request);
    const MotionClip& clip = result.clip;
    const int frames = clip.frame_count();
    EXPECT_THAT(result.report.steps.front().primitive, EndsWith("_first_start"));
    EXPECT_THAT(result.report.steps.back().primitive, EndsWith("_end"));
    EXPECT_EQ(result.report.steps.front().from, 0);
    EXPECT_EQ(result.report.steps.back().to, frames - 1);
    for (size_t i = 1; i < result.report.steps.size(); ++i) {
      EXPECT_EQ(result.report.steps[i].from, result.report.steps[i - 1].to + 1);
      EXPECT_TRUE(std::isfinite(result.report.steps[i].log_likelihood));
    }
    for (int f = 0; f < 3; ++f) {
      EXPECT_LT(Speed(clip, f), 0.15) << seed << " frame " << f;
      EXPECT_LT(Speed(clip, frames - 2 - f), 0.15) << seed << " frame " << frames - 2 - f;
    }
    EXPECT_LT(WayOfFeet(clip, 0, 3), 0.005) << seed;
    EXPECT_LT(WayOfFeet(clip, frames - 4, 3), 0.005) << seed;
    EXPECT_GT(Speed(clip, frames / 2), 0.5) << seed;
  }
}

TEST(WalkBoundary, StartsAndStopsWithoutPops) {
  // The same bound as for steps inside the walk.
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SynthesisRequest request = Whole(seed);
    request.duration_s = 5;
    const auto positions = JointPositions(Synthesize(*testing::SmallModel(), request).clip);
    double fastest = 0, lowest = 0;
    for (size_t f = 2; f < positions.size(); ++f) {
      const Eigen::Matrix3Xd kick = positions[f] - 2 * positions[f - 1] + positions[f - 2];
      fastest = std::max(fastest, kick.colwise().norm().maxCoeff() * 900);
      lowest = std::min(lowest, positions[f].row(1).minCoeff());
    }
    EXPECT_LT(fastest, 150) << seed;
    EXPECT_GT(lowest, -0.01) << seed;
  }
}

TEST(WalkBoundary, StepsCountTheFirstAndTheLast) {
  for (int steps = 3; steps <= 9; ++steps) {
    SynthesisRequest request = Whole(5);
    request.steps = steps;
    const SynthesisResult result = Synthesize(*testing::SmallModel(), request);
    EXPECT_EQ(result.report.steps.size(), static_cast<size_t>(steps));
    EXPECT_THAT(result.report.steps.back().primitive, EndsWith("_end"));
  }
  SynthesisRequest request = Whole(5);
  request.steps = 1;
  try {
    Synthesize(*testing::SmallModel(), request);
    FAIL() << "started and stopped in one step";
  } catch (const UnsatisfiableRequest& error) {
    EXPECT_EQ(error.pointer(), "/steps");
    EXPECT_THAT(error.what(), HasSubstr("the nearest has 3"));
  }
}

TEST(WalkBoundary, AWalkThatStopsLastsAboutAsLongAsAsked) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (const double duration_s : {4.0, 6.3, 12.0}) {
      SynthesisRequest request = Whole(seed);
      request.duration_s = duration_s;
      const SynthesisReport report = Synthesize(*testing::SmallModel(), request).report;
      EXPECT_NEAR(report.duration_s, (report.frames - 1) / 30.0, 1e-9);
      // Half a step is the most that whole steps can miss by, and that ends differ by a little.
      int longest = 0;
      for (const StepReport& step : report.steps) longest = std::max(longest, step.to - step.from);
      EXPECT_LT(std::abs(report.duration_s - duration_s), 0.5 * longest / 30 + 0.05) << seed << ", " << duration_s;
    }
  }
  // Too short a time is met by the shortest walk that there is.
  SynthesisRequest request = Whole(1);
  request.duration_s = 0.1;
  EXPECT_EQ(Synthesize(*testing::SmallModel(), request).report.steps.size(), 3u);
}

TEST(WalkBoundary, ALongerWalkBeginsWithTheSameSteps) {
  SynthesisRequest request = Whole(8);
  request.duration_s = 5;
  const SynthesisReport shorter = Synthesize(*testing::SmallModel(), request).report;
  request.duration_s = 9;
  const SynthesisReport longer = Synthesize(*testing::SmallModel(), request).report;
  ASSERT_GT(longer.steps.size(), shorter.steps.size());
  for (size_t i = 0; i + 1 < shorter.steps.size(); ++i) {
    EXPECT_EQ(longer.steps[i].primitive, shorter.steps[i].primitive);
    EXPECT_EQ(longer.steps[i].log_likelihood, shorter.steps[i].log_likelihood);
  }
}

TEST(WalkBoundary, EitherEndCanBeAskedForAlone) {
  SynthesisRequest request = Whole(4);
  request.duration_s = 5;
  request.end = WalkBoundary::kWalking;
  const SynthesisResult starts = Synthesize(*testing::SmallModel(), request);
  EXPECT_EQ(starts.clip.frame_count(), 151) << "a walk that goes on is cut where it was asked to be";
  EXPECT_LT(Speed(starts.clip, 0), 0.15);
  EXPECT_GT(Speed(starts.clip, 149), 0.4);
  request.start_from = WalkBoundary::kWalking;
  request.end = WalkBoundary::kStanding;
  const SynthesisResult stops = Synthesize(*testing::SmallModel(), request);
  EXPECT_GT(Speed(stops.clip, 0), 0.4);
  EXPECT_LT(Speed(stops.clip, stops.clip.frame_count() - 2), 0.15);
}

// Walks cut just after their walker set off: no standing, but a first step that still gathers speed.
std::shared_ptr<const MotionGraph> SlowStartModel() {
  static const std::shared_ptr<const MotionGraph> model = [] {
    std::vector<TrainingClip> clips;
    for (int i = 0; i < 6; ++i) {
      SyntheticGaitOptions options;
      options.seed = static_cast<std::uint64_t>(300 + i);
      options.frame_rate_hz = 30;
      options.steps = 14;
      options.left_first = i % 2 == 0;
      options.stop_standing = false;
      SyntheticGaitTruth truth;
      const MotionClip whole = GenerateGait(options, &truth);
      const int cut = static_cast<int>(30 * (truth.strikes[0].time_s - 0.2));
      clips.push_back({whole.Slice(cut, whole.frame_count() - cut), true});
    }
    return BuildGraph(clips, {});
  }();
  return model;
}

TEST(WalkBoundary, ASlowFirstStepIsAStartThatGathersSpeed) {
  const MotionGraph& graph = *SlowStartModel();
  const std::vector<StyleBoundaries> boundaries = FindBoundaries(graph);
  ASSERT_EQ(boundaries.size(), 1u);
  EXPECT_THAT(boundaries[0].starts, ::testing::ElementsAre(WalkBoundary::kWalking, WalkBoundary::kSlowStep));
  EXPECT_THAT(boundaries[0].ends, ::testing::ElementsAre(WalkBoundary::kWalking));
  SynthesisRequest request;
  request.duration_s = 5;
  request.start_from = WalkBoundary::kSlowStep;
  for (request.seed = 0; request.seed < 6; ++request.seed) {
    const SynthesisResult result = Synthesize(graph, request);
    EXPECT_THAT(result.report.steps.front().primitive, EndsWith("_first_start"));
    const auto mean_speed = [&](int from, int to) {
      return (result.clip.root_positions().col(to) - result.clip.root_positions().col(from)).norm() * 30 / (to - from);
    };
    EXPECT_LT(mean_speed(0, result.report.steps[0].to), 0.9 * mean_speed(60, 150)) << request.seed;
  }
}

TEST(WalkBoundary, WhatWasNotLearnedIsRefusedWithWhatWas) {
  SynthesisRequest request = Whole(1);
  try {
    Synthesize(*SlowStartModel(), request);
    FAIL() << "started out of standing that it never saw";
  } catch (const UnsatisfiableRequest& error) {
    EXPECT_EQ(error.pointer(), "/start/from");
    EXPECT_THAT(error.what(), HasSubstr("walking, slow_step"));
  }
  request.start_from = WalkBoundary::kSlowStep;
  EXPECT_THROW(Synthesize(*SlowStartModel(), request), UnsatisfiableRequest);
  request.end = WalkBoundary::kWalking;
  request.style = "slow";
  try {
    Synthesize(*testing::SmallModel(), request);
    FAIL() << "made a slow first step that it never saw";
  } catch (const UnsatisfiableRequest& error) {
    EXPECT_EQ(error.pointer(), "/start/from");
    EXPECT_THAT(error.what(), HasSubstr("walking, standing"));
    EXPECT_THAT(error.what(), HasSubstr("styles that can start from \"slow_step\": none"));
  }
}

}  // namespace
}  // namespace morphograph
