// Walks learned from recordings against those recordings: what the README promises, with the figures' own definitions.

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/augmentation.h"
#include "datasets/dataset_loader.h"
#include "datasets/resample.h"
#include "graph/graph_builder.h"
#include "synthesis/evaluation.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/set_quality.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

struct Judgement {
  SetQuality drawn, captured;
  SetComparison comparison;
};

// Learns from the clips and judges 100 walks of 10 s against them, on pieces of `piece_frames` at 30 fps.
Judgement LearnAndJudge(std::vector<MotionClip> captured, int piece_frames) {
  std::vector<TrainingClip> training;
  for (AugmentedClip& level : Augment(captured, {})) training.push_back({std::move(level.clip)});
  TrainingOptions options;
  options.jobs = 2;
  const auto graph = BuildGraph(training, options);
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
  return {MeasureSet(drawn, {.piece_frames = piece_frames}), MeasureSet(captured, {.piece_frames = piece_frames}),
          CompareSets(drawn, captured)};
}

void ExpectAsGoodAsCaptured(const Judgement& judgement) {
  const auto& [drawn, captured, comparison] = judgement;
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

TEST(CapturedQuality, WalksOfOneStyleOfBnrAreAsGoodAsTheirRecordings) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::filesystem::path bnr = testing::SharedData() / "bnr" / "dataset-2";
  std::vector<MotionClip> clips;
  for (LoadedClip& loaded : LoadDataset({bnr / "walk", bnr / "walk-turn-left", bnr / "walk-turn-right"}, {}, 2).clips) {
    if (loaded.clip.style == "youthful") clips.push_back(std::move(loaded.clip));
  }
  ASSERT_EQ(clips.size(), 59u);
  const Judgement judgement = LearnAndJudge(std::move(clips), 90);
  ExpectAsGoodAsCaptured(judgement);
  EXPECT_LE(judgement.drawn.acceleration_p999_m_s2, 1.2 * judgement.captured.acceleration_p999_m_s2);
}

}  // namespace
}  // namespace morphograph
