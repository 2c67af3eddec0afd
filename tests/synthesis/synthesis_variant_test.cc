#include "synthesis/synthesis_variant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/graph_builder.h"
#include "synthesis/motion_synthesizer.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

MotionClip Draw(const MotionGraph& graph, const SynthesisVariant& variant) {
  SynthesisRequest request;
  request.seed = 5;
  request.style = graph.styles().back().name;
  request.duration_s = 6;
  return Synthesize(graph, request, variant).clip;
}

double Difference(const MotionClip& a, const MotionClip& b, int frame, JointRole role) {
  const int joint = a.skeleton().roles()[role];
  return a.rotation(frame, joint).angularDistance(b.rotation(frame, joint));
}

TEST(SynthesisVariant, WithoutFootLockOnlyTheLegsDiffer) {
  const auto graph = testing::SmallModel();
  const MotionClip locked = Draw(*graph, {}), free = Draw(*graph, {.foot_lock = false});
  ASSERT_EQ(locked.frame_count(), free.frame_count());
  double legs = 0, arms = 0;
  for (int f = 0; f < locked.frame_count(); ++f) {
    legs = std::max(legs, Difference(locked, free, f, JointRole::kLeftKnee));
    arms = std::max(arms, Difference(locked, free, f, JointRole::kLeftElbow));
  }
  EXPECT_GT(legs, 0.01);
  EXPECT_EQ(arms, 0);
}

TEST(SynthesisVariant, AHardCutDiffersNearKeyFramesOnly) {
  const auto graph = testing::SmallModel();
  SynthesisRequest request;
  request.seed = 5;
  request.style = "slow";
  request.duration_s = 6;
  const SynthesisResult faded = Synthesize(*graph, request, {.foot_lock = false});
  const MotionClip cut = Synthesize(*graph, request, {.cross_fade = false, .foot_lock = false}).clip;
  ASSERT_EQ(cut.frame_count(), faded.clip.frame_count());
  double near = 0, away = 0;
  for (int f = 0; f < cut.frame_count(); ++f) {
    int distance = cut.frame_count();
    for (const StepReport& step : faded.report.steps) distance = std::min(distance, std::abs(step.from - f));
    double& worst = distance <= 3 ? near : away;
    worst = std::max(worst, Difference(cut, faded.clip, f, JointRole::kLeftKnee));
  }
  EXPECT_GT(near, 1e-3);
  EXPECT_LT(away, 1e-9);
}

TEST(SynthesisVariant, AModelInEulerAnglesWalksAsOneInLogMaps) {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : testing::SmallWalks()) {
    if (clip.style == "slow") clips.push_back({std::move(clip), true});
  }
  TrainingOptions options;
  options.variant.euler = true;
  const auto graph = BuildGraph(clips, options);
  const MotionClip euler = Draw(*graph, {}), usual = Draw(*testing::SmallModel(), {});
  const auto speed = [](const MotionClip& clip) {
    return (clip.root_positions().rightCols<1>() - clip.root_positions().leftCols<1>()).norm() / clip.duration_s();
  };
  EXPECT_NEAR(speed(euler), speed(usual), 0.1);
  // A pose of one is near to some pose of the other: a wrong conversion would turn limbs anywhere.
  for (const JointRole role : {JointRole::kLeftKnee, JointRole::kRightHip, JointRole::kHead, JointRole::kRightElbow}) {
    const int joint = euler.skeleton().roles()[role];
    for (int f = 0; f < euler.frame_count(); f += 5) {
      double nearest = 10;
      for (int g = 0; g < usual.frame_count(); ++g) {
        nearest = std::min(nearest, euler.rotation(f, joint).angularDistance(usual.rotation(g, joint)));
      }
      EXPECT_LT(nearest, 0.1) << RoleName(role) << " frame " << f;
    }
  }
}

}  // namespace
}  // namespace morphograph
