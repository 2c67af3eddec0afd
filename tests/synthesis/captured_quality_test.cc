// Walks learned from recordings against those recordings: what the README promises, with the figures' own definitions.

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/augmentation.h"
#include "datasets/dataset_loader.h"
#include "datasets/resample.h"
#include "graph/graph_builder.h"
#include "synthesis/evaluation.h"
#include "synthesis/graph_walk.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/set_quality.h"
#include "tests/support/shared_data.h"
#include "tests/synthesis/mean_speed.h"

namespace morphograph {
namespace {

struct Judgement {
  SetQuality drawn, captured;
  SetComparison comparison;
  double variance = 0;    // of whitened latents after many steps, where 1 is meant
  double worst_mean = 0;  // largest mean of any of them, where 0 is meant
};

// 200 walks of 200 steps each, the first 20 left out; worst of the graph's primitives.
void JudgeMarginal(const MotionGraph& graph, Judgement* judgement) {
  std::mt19937_64 rng(1);
  judgement->variance = 1;
  std::vector<Eigen::VectorXd> sums(graph.primitive_count()), squares(graph.primitive_count());
  std::vector<int> counts(graph.primitive_count(), 0);
  for (int walk = 0; walk < 200; ++walk) {
    WalkStep step = DrawFirstStep(graph, walk % graph.primitive_count(), rng);
    for (int i = 0; i < 200; ++i) {
      step = DrawNextStep(graph, step, graph.out_edges(step.primitive).front(), rng);
      if (i < 20) continue;
      if (counts[step.primitive]++ == 0) sums[step.primitive] = squares[step.primitive] = Eigen::VectorXd::Zero(step.whitened.size());
      sums[step.primitive] += step.whitened;
      squares[step.primitive] += step.whitened.cwiseAbs2();
    }
  }
  for (int p = 0; p < graph.primitive_count(); ++p) {
    if (counts[p] == 0) continue;  // a start: no walk comes back to it
    const double variance = squares[p].mean() / counts[p];
    if (std::abs(variance - 1) >= std::abs(judgement->variance - 1)) judgement->variance = variance;
    judgement->worst_mean = std::max(judgement->worst_mean, sums[p].cwiseAbs().maxCoeff() / counts[p]);
  }
}

std::shared_ptr<const MotionGraph> Learn(const std::vector<MotionClip>& captured) {
  std::vector<TrainingClip> training;
  for (AugmentedClip& level : Augment(captured, {})) training.push_back({std::move(level.clip)});
  TrainingOptions options;
  options.jobs = 2;
  return BuildGraph(training, options);
}

// Learns from the clips and judges 100 walks of 10 s against them, on pieces of `piece_frames` at 30 fps.
Judgement LearnAndJudge(std::vector<MotionClip> captured, int piece_frames) {
  const auto graph = Learn(captured);
  std::vector<MotionClip> drawn;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SynthesisRequest request;
    request.seed = seed;
    request.duration_s = 10;
    drawn.push_back(Synthesize(*graph, request).clip);
  }
  for (MotionClip& clip : captured) {
    if (std::abs(clip.frame_rate_hz() - 30) > 0.03) clip = Resample(clip, 30);
  }
  Judgement judgement{MeasureSet(drawn, {.piece_frames = piece_frames}), MeasureSet(captured, {.piece_frames = piece_frames}),
                      CompareSets(drawn, captured), 1, 0};
  JudgeMarginal(*graph, &judgement);
  return judgement;
}

void ExpectAsGoodAsCaptured(const Judgement& judgement) {
  const auto& [drawn, captured, comparison, variance, worst_mean] = judgement;
  EXPECT_NEAR(variance, 1, 0.05);
  EXPECT_LT(worst_mean, 0.1);
  EXPECT_LE(drawn.contact_distance_m, 1.05 * captured.contact_distance_m);
  EXPECT_GE(drawn.naturalness, 0.8 * captured.naturalness);
  EXPECT_LE(drawn.naturalness, 1.2 * captured.naturalness);
  EXPECT_LE(drawn.foot_skate_cm_s, captured.foot_skate_cm_s);
  EXPECT_LE(comparison.frechet_ratio, 2);
  EXPECT_GE(drawn.min_knee_flexion_deg, std::min(0.0, captured.min_knee_flexion_deg) - 1);
  EXPECT_GE(drawn.lowest_m, captured.lowest_m - 0.01);
  EXPECT_LE(drawn.bone_length_error_m, 1e-9);
}

TEST(CapturedQuality, WalksOfCmuAreAsGoodAsTheirRecordings) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<MotionClip> clips;
  for (LoadedClip& loaded : LoadDataset({testing::SharedData() / "cmu" / "07", testing::SharedData() / "cmu" / "08"}).clips) {
    clips.push_back(std::move(loaded.clip));
  }
  ASSERT_EQ(clips.size(), 23u);
  const Judgement judgement = LearnAndJudge(std::move(clips), 60);
  ExpectAsGoodAsCaptured(judgement);
}

std::vector<MotionClip> WalksAndTurnsOfBnr(const std::string& style) {
  const std::filesystem::path bnr = testing::SharedData() / "bnr" / "dataset-2";
  std::vector<MotionClip> clips;
  for (LoadedClip& loaded : LoadDataset({bnr / "walk", bnr / "walk-turn-left", bnr / "walk-turn-right"}, {}, 2).clips) {
    if (loaded.clip.style == style) clips.push_back(std::move(loaded.clip));
  }
  return clips;
}

TEST(CapturedQuality, WalksOfOneStyleOfBnrAreAsGoodAsTheirRecordings) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<MotionClip> clips = WalksAndTurnsOfBnr("youthful");
  ASSERT_EQ(clips.size(), 59u);
  const Judgement judgement = LearnAndJudge(std::move(clips), 90);
  ExpectAsGoodAsCaptured(judgement);
  EXPECT_LE(judgement.drawn.acceleration_p999_m_s2, 1.2 * judgement.captured.acceleration_p999_m_s2);
}

// A walker who goes straight on when not told a way must not creep along a bending one for want of steps that turn.
TEST(CapturedQuality, WalksDoNotCreepAlongABendingWay) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const auto graph = Learn(WalksAndTurnsOfBnr("elderly"));
  double told_m_s = 0, untold_m_s = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    SynthesisRequest request;
    request.seed = seed;
    request.control.path = PathTerm{.points_m = {{0, 0}, {0.5, 2}, {2, 3}, {3.5, 2}, {4, 0}, {6, 0}}, .smooth = true};
    const SynthesisResult told = Synthesize(*graph, request);
    for (const ControlOutcome& outcome : told.report.constraints) EXPECT_TRUE(outcome.met) << outcome.pointer << ", seed " << seed;
    told_m_s += testing::MeanSpeed(told);
    request.control.path.reset();
    request.duration_s = told.report.duration_s;
    untold_m_s += testing::MeanSpeed(Synthesize(*graph, request));
  }
  EXPECT_GT(told_m_s / untold_m_s, 0.83);
  EXPECT_LT(told_m_s / untold_m_s, 1.1);
}

}  // namespace
}  // namespace morphograph
