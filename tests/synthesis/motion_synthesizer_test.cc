#include "synthesis/motion_synthesizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/forward_kinematics.h"
#include "datasets/leg_ik.h"
#include "synthesis/evaluation.h"
#include "tests/support/small_model.h"
#include "tests/support/two_actions.h"

namespace morphograph {
namespace {

SynthesisRequest Request(std::uint64_t seed, double duration_s) {
  SynthesisRequest request;
  request.seed = seed;
  request.duration_s = duration_s;
  return request;
}

std::string Bytes(const SynthesisRequest& request) {
  return WriteBvh(ExportClip(Synthesize(*testing::SmallModel(), request).clip));
}

TEST(MotionSynthesizer, SameSeedGivesSameBytesOnAnyThread) {
  const std::string alone = Bytes(Request(42, 6));
  std::vector<std::string> results(8);
  {
    std::vector<std::jthread> threads;
    for (std::string& result : results) threads.emplace_back([&result] { result = Bytes(Request(42, 6)); });
  }
  for (const std::string& result : results) EXPECT_EQ(result, alone);
  EXPECT_NE(Bytes(Request(43, 6)), alone);
}

TEST(MotionSynthesizer, LastsAsLongAsAsked) {
  const SynthesisResult result = Synthesize(*testing::SmallModel(), Request(1, 8));
  EXPECT_EQ(result.clip.frame_count(), 241);
  EXPECT_NEAR(result.report.duration_s, 8, 1e-9);
  EXPECT_EQ(result.report.path_m.size(), 241u);
  int next = 0;  // steps cover the clip without gaps
  for (const StepReport& step : result.report.steps) {
    EXPECT_EQ(step.from, next);
    EXPECT_GE(step.to, step.from);
    EXPECT_TRUE(std::isfinite(step.log_likelihood));
    next = step.to + 1;
  }
  EXPECT_EQ(next, 241);
}

TEST(MotionSynthesizer, TakesTheStepsAskedLeftAndRightInTurn) {
  SynthesisRequest request;
  request.steps = 12;
  const SynthesisResult result = Synthesize(*testing::SmallModel(), request);
  ASSERT_EQ(result.report.steps.size(), 12u);
  for (size_t i = 1; i < 12; ++i) EXPECT_NE(result.report.steps[i].primitive, result.report.steps[i - 1].primitive) << i;
}

TEST(MotionSynthesizer, StartsWhereAndHowItIsTold) {
  SynthesisRequest request = Request(3, 2);
  request.start = {{4, -2}, M_PI / 2};
  const SynthesisResult result = Synthesize(*testing::SmallModel(), request);
  EXPECT_NEAR(result.clip.root_positions()(0, 0), 4, 1e-9);
  EXPECT_NEAR(result.clip.root_positions()(2, 0), -2, 1e-9);
  EXPECT_NEAR(HeadingRad(result.clip, 0), M_PI / 2, 1e-3);
  EXPECT_GT(result.clip.root_positions()(0, 60), 5) << "heading 90 degrees walks along +X";
}

TEST(MotionSynthesizer, StylesDifferAndUnknownOnesAreRefused) {
  SynthesisRequest request = Request(9, 6);
  request.style = "brisk";
  const auto distance = [&] {
    const SynthesisResult result = Synthesize(*testing::SmallModel(), request);
    EXPECT_EQ(result.report.style, *request.style);
    return (result.clip.root_positions().rightCols(1) - result.clip.root_positions().leftCols(1)).norm();
  };
  const double brisk = distance();
  request.style = "slow";
  EXPECT_GT(brisk, 1.2 * distance());
  request.style = "moonwalk";
  try {
    Synthesize(*testing::SmallModel(), request);
    FAIL() << "made up a style";
  } catch (const UnsatisfiableRequest& error) {
    EXPECT_EQ(error.pointer(), "/style");
    EXPECT_THAT(error.what(), ::testing::HasSubstr("brisk, slow"));
  }
}

TEST(MotionSynthesizer, ClipsShowTheActionThatIsAskedFor) {
  const auto both = testing::ModelOfTwoActions();
  SynthesisRequest request = Request(5, 4);
  const SynthesisResult usual = Synthesize(*both, request);
  EXPECT_EQ(usual.report.action, "walk");
  EXPECT_EQ(WriteBvh(ExportClip(usual.clip)), Bytes(request)) << "walks as the model of walking alone does";
  for (const StepReport& step : usual.report.steps) EXPECT_TRUE(step.primitive.ends_with("_walk")) << step.primitive;

  request.action = "run";
  for (const WalkBoundary from : {WalkBoundary::kWalking, WalkBoundary::kStanding}) {
    request.start_from = from;
    const SynthesisResult run = Synthesize(*both, request);
    EXPECT_EQ(run.report.action, "run");
    EXPECT_EQ(run.report.style, "brisk") << "the only one that runs";
    for (size_t i = from == WalkBoundary::kWalking ? 0 : 1; i < run.report.steps.size(); ++i) {
      EXPECT_TRUE(run.report.steps[i].primitive.ends_with("_run")) << run.report.steps[i].primitive;
    }
  }
  const auto refusal = [&]() -> std::string {
    try {
      Synthesize(*both, request);
    } catch (const UnsatisfiableRequest& error) {
      return error.pointer() + " " + error.what();
    }
    return "made";
  };
  request.style = "slow";
  EXPECT_EQ(refusal().find("/style the model has no style 'slow' of action 'run'; it has brisk"), 0u) << refusal();
  request.action = "crawl";
  EXPECT_EQ(refusal().find("/action the model has no action 'crawl'; it has walk, run"), 0u) << refusal();
}

// Names of the made steps of a clip.
std::vector<std::string> MadeSteps(const SynthesisReport& report) {
  std::vector<std::string> names;
  for (const StepReport& step : report.steps) {
    if (step.primitive.find("_to_") != std::string::npos) names.push_back(step.primitive.substr(step.primitive.find('_') + 1));
  }
  return names;
}

TEST(MotionSynthesizer, ChangesItsActionWhenItIsAskedTo) {
  const auto both = testing::ModelOfTwoActions();
  SynthesisRequest request = Request(5, 9);
  EXPECT_TRUE(MadeSteps(Synthesize(*both, request).report).empty());
  EXPECT_TRUE(Synthesize(*both, request).report.actions.empty());

  request.changes = {{.at_s = 3, .action = "run"}, {.at_s = 6, .action = "walk"}};
  const SynthesisResult result = Synthesize(*both, request);
  EXPECT_THAT(MadeSteps(result.report), ::testing::ElementsAre("walk_to_run", "run_to_walk"));
  EXPECT_EQ(result.report.style, "brisk") << "the only one that does both";
  ASSERT_EQ(result.report.actions.size(), 3u);
  EXPECT_EQ(result.report.actions[0].action, "walk");
  EXPECT_EQ(result.report.actions[1].action, "run");
  EXPECT_NEAR(result.report.actions[1].from, 90, 10);
  EXPECT_EQ(result.report.actions[2].action, "walk");
  EXPECT_NEAR(result.report.actions[2].from, 180, 10);
  EXPECT_EQ(result.clip.frame_count(), 271);
  for (const StepReport& step : result.report.steps) {
    const std::string wanted = step.to < result.report.actions[1].from || step.from >= result.report.actions[2].from ? "_walk" : "_run";
    EXPECT_TRUE(step.primitive.ends_with(wanted)) << step.primitive << " from frame " << step.from;
  }
  // As smooth and as firm on its feet as a clip of one action.
  const SynthesisResult plain = Synthesize(*both, Request(5, 9));
  EXPECT_LT(result.report.quality.foot_skate_cm_s, 1.2 * plain.report.quality.foot_skate_cm_s + 1);
  EXPECT_LT(result.report.quality.contact_distance_m, 1.2 * plain.report.quality.contact_distance_m + 0.001);
}

TEST(MotionSynthesizer, RefusesChangesOfActionThatNoStyleCanMake) {
  const auto both = testing::ModelOfTwoActions();
  const auto refusal = [&](const SynthesisRequest& request) -> std::string {
    try {
      Synthesize(*both, request);
    } catch (const UnsatisfiableRequest& error) {
      return error.pointer() + " " + error.what();
    }
    return "made";
  };
  SynthesisRequest request = Request(1, 6);
  request.changes = {{.at_s = 3, .action = "run"}};
  request.style = "slow";
  EXPECT_THAT(refusal(request), ::testing::AllOf(::testing::StartsWith("/actions/1/action style 'slow' cannot change from 'walk' to 'run'"),
                                                 ::testing::HasSubstr("can change as asked: brisk")));
  request.changes[0].action = "crawl";
  EXPECT_THAT(refusal(request), ::testing::StartsWith("/actions/1/action the model has no action 'crawl'; it has walk, run"));
  request.changes = {{.at_s = 7, .action = "run"}};
  EXPECT_THROW(Synthesize(*both, request), std::invalid_argument) << "after its end";
  request.changes = {{.at_s = 3, .action = "run"}};
  request.control.goal = GoalTerm{.position_m = Eigen::Vector2d(0, 5)};
  EXPECT_THROW(Synthesize(*both, request), std::invalid_argument) << "on a way";
}

TEST(MotionSynthesizer, SteeredClipsShowTheActionThatIsAskedFor) {
  SynthesisRequest request;
  request.seed = 3;
  request.action = "run";
  request.control.goal = GoalTerm{.position_m = Eigen::Vector2d(0, 5)};
  const SynthesisResult run = Synthesize(*testing::ModelOfTwoActions(), request);
  for (const StepReport& step : run.report.steps) EXPECT_TRUE(step.primitive.ends_with("_run")) << step.primitive;
}

TEST(MotionSynthesizer, RefusesNumbersOutOfRange) {
  for (const double duration : {0.0, -1.0, 601.0, std::nan("")}) {
    EXPECT_THROW(Synthesize(*testing::SmallModel(), Request(1, duration)), std::invalid_argument) << duration;
  }
  SynthesisRequest both = Request(1, 2);
  both.steps = 3;
  EXPECT_EQ(both.FirstProblem()->first, "/steps");
  SynthesisRequest none;
  none.steps = 0;
  EXPECT_EQ(none.FirstProblem()->first, "/steps");
}

TEST(MotionSynthesizer, JoinsWithoutPopsAndKeepsTheBody) {
  // Walks without step-to-step jumps: joints of the synthetic walk itself peak below 150 m/s^2 at this rate.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SynthesisResult result = Synthesize(*testing::SmallModel(), Request(seed, 6));
    const MotionClip& clip = result.clip;
    const LegIk legs[2] = {LegIk(clip.skeleton(), Foot::kLeft), LegIk(clip.skeleton(), Foot::kRight)};
    const auto positions = JointPositions(clip);
    double fastest = 0, lowest = 0;
    for (int f = 2; f < clip.frame_count(); ++f) {
      const Eigen::Matrix3Xd kick = positions[f] - 2 * positions[f - 1] + positions[f - 2];
      fastest = std::max(fastest, kick.colwise().norm().maxCoeff() * 900);
      lowest = std::min(lowest, positions[f].row(1).minCoeff());
      for (const LegIk& leg : legs) {
        EXPECT_GT(leg.Measure(clip.root_positions().col(f), clip.rotations(f)).knee_bend_rad, -0.02) << seed << " " << f;
      }
    }
    EXPECT_LT(fastest, 150) << seed;
    EXPECT_GT(lowest, -0.01) << seed;
  }
}

TEST(MotionSynthesizer, FeetStandStillWhileTheyArePlanted) {
  double skate = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const SynthesisResult result = Synthesize(*testing::SmallModel(), Request(seed, 6));
    skate += result.report.quality.foot_skate_cm_s / 10;
    EXPECT_GE(result.report.contacts.size(), 8u) << seed;
    EXPECT_LT(result.report.quality.contact_distance_m, 0.01) << seed;
  }
  double learned_from = 0;
  const auto walks = testing::SmallWalks();
  for (const auto& [name, clip] : walks) {
    // The steady middle: standing feet do not skate.
    const MotionClip steady = clip.Slice(75, clip.frame_count() - 150);
    learned_from += EvaluateClip(steady).quality.foot_skate_cm_s / static_cast<double>(walks.size());
  }
  EXPECT_LT(skate, 1.2 * learned_from);
}

TEST(MotionSynthesizer, FrameRateDoesNotChangeTheMotion) {
  SynthesisRequest request = Request(5, 4);
  const SynthesisResult coarse = Synthesize(*testing::SmallModel(), request);
  request.frame_rate_hz = 120;
  const SynthesisResult fine = Synthesize(*testing::SmallModel(), request);
  ASSERT_EQ(fine.clip.frame_count(), 481);
  for (int f = 0; f <= 120; f += 10) {
    EXPECT_LT((fine.clip.root_positions().col(4 * f) - coarse.clip.root_positions().col(f)).norm(), 0.02) << f;
  }
}

}  // namespace
}  // namespace morphograph
