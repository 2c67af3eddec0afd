#include <gtest/gtest.h>

#include <cmath>

#include "datasets/dataset_loader.h"
#include "synthesis/clip_ends.h"
#include "synthesis/evaluation.h"
#include "synthesis/pose_windows.h"
#include "synthesis/set_quality.h"
#include "synthesis/style_classifier.h"
#include "tests/support/shared_data.h"
#include "tests/synthesis/gait_clips.h"

namespace morphograph {
namespace {

using testing::GaitClip;
using testing::GaitClips;

void AsIs(SyntheticGaitOptions&) {}

TEST(PoseWindows, HaveTheDefinedSizeAndCount) {
  const MotionClip clip = GaitClip(1).Slice(0, 100);
  const Eigen::MatrixXd windows = PoseWindows(PrepareEvaluation(clip));
  EXPECT_EQ(windows.rows(), 5 * (14 * 3 + 2));
  EXPECT_EQ(windows.cols(), (100 - 15) / 7 + 1);
  EXPECT_EQ(PoseWindows(PrepareEvaluation(clip.Slice(0, 15))).cols(), 1);
  EXPECT_EQ(PoseWindows(PrepareEvaluation(clip.Slice(0, 14))).cols(), 0);
}

TEST(ClipEnds, AreCutWhereASecondIsLeft) {
  const MotionClip clip = GaitClip(1);
  const std::vector<MotionClip> cut = WithoutEnds({clip.Slice(0, 90), clip.Slice(0, 89), clip.Slice(0, 100)});
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_EQ(cut[0].frame_count(), 30);
  EXPECT_EQ(cut[1].frame_count(), 40);
  EXPECT_EQ(cut[1].root_positions().col(0), clip.root_positions().col(30));
  EXPECT_EQ(WithoutEnds({clip.Slice(0, 90)}, 0).at(0).frame_count(), 90);
}

TEST(PoseWindows, IgnoreHeadingFloorPositionAndFloorHeight) {
  const MotionClip clip = GaitClip(2);
  MotionClip moved = Moved(clip, -2.0, -4, 9);
  moved.root_positions().row(1).array() -= 0.7;
  const Eigen::MatrixXd a = PoseWindows(PrepareEvaluation(clip)), b = PoseWindows(PrepareEvaluation(moved));
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PoseFeatures, PointLeftUpAndForward) {
  const MotionClip clip = GaitClip(3, [](SyntheticGaitOptions& options) { options.heading_rad = 2.0; });
  const Eigen::MatrixXd features = PoseFeatures(PrepareEvaluation(clip));
  const Eigen::VectorXd mean = features.rowwise().mean();
  // Roles in order: hips, left hip, right hip, ..., the velocity last.
  EXPECT_GT(mean[3], 0.05);              // left hip is on the left
  EXPECT_NEAR(mean[3], -mean[6], 0.01);  // right hip on the right
  EXPECT_GT(mean[1], 0.7);               // hips are above the ground
  EXPECT_NEAR(mean[43], 1.3, 0.15);      // walks forward at the speed asked for
  EXPECT_NEAR(mean[42], 0, 0.05);
}

TEST(CompareSets, OfTwoHalvesOfOneKindIsNearTheFloor) {
  const SetComparison comparison = CompareSets(GaitClips(10, 10, AsIs), GaitClips(40, 20, AsIs));
  EXPECT_LT(comparison.frechet_ratio, 2.0);
  EXPECT_NEAR(comparison.residual_ratio, 1, 0.3);
  EXPECT_GT(comparison.frechet_halves, 0);
  EXPECT_NEAR(comparison.diversity / comparison.diversity_reference, 1, 0.1);
}

TEST(CompareSets, TellsAnotherWayOfWalking) {
  const std::vector<MotionClip> reference = GaitClips(40, 20, AsIs);
  const SetComparison faster = CompareSets(
      GaitClips(10, 10, [](SyntheticGaitOptions& options) { options.speed_m_s += 0.4; }), reference);
  EXPECT_GT(faster.frechet_ratio, 10);
  // A bend of the trunk that the reference never shows lies across its leading directions.
  const SetComparison stooped = CompareSets(
      GaitClips(10, 10, [](SyntheticGaitOptions& options) { options.stoop_rad = 0.3; }), reference);
  EXPECT_GT(stooped.residual_ratio, 3);
  // One clip, repeated: near the reference's mean, without its spread.
  const SetComparison same = CompareSets(std::vector<MotionClip>(10, reference.front()), reference);
  EXPECT_GT(same.frechet_ratio, 1.5);
}

TEST(CompareSets, IsTheSameForTheSameSeed) {
  const std::vector<MotionClip> set = GaitClips(10, 5, AsIs), reference = GaitClips(40, 8, AsIs);
  const SetComparison a = CompareSets(set, reference, 3), b = CompareSets(set, reference, 3);
  EXPECT_EQ(a.frechet_ratio, b.frechet_ratio);
  EXPECT_EQ(a.diversity, b.diversity);
}

TEST(CompareSets, RefusesSetsThatAreTooSmall) {
  const std::vector<MotionClip> enough = GaitClips(40, 8, AsIs);
  EXPECT_THROW(CompareSets({}, enough), std::invalid_argument);
  EXPECT_THROW(CompareSets({enough.front()}, enough), std::invalid_argument);
  EXPECT_THROW(CompareSets(enough, {enough[0], enough[1], enough[2]}), std::invalid_argument);
}

TEST(SetQuality, DoesNotDependOnHowLongTheClipsAre) {
  const std::vector<MotionClip> clips = GaitClips(70, 6, AsIs);
  std::vector<MotionClip> cut;
  for (const MotionClip& clip : clips) {
    for (int first = 0; first + 90 <= clip.frame_count(); first += 90) cut.push_back(clip.Slice(first, 90));
  }
  const SetQuality a = MeasureSet(clips), b = MeasureSet(cut);
  EXPECT_EQ(a.pieces, b.pieces);
  EXPECT_EQ(a.contact_distance_m, b.contact_distance_m);
  EXPECT_EQ(a.naturalness, b.naturalness);
  EXPECT_EQ(a.acceleration_p999_m_s2, b.acceleration_p999_m_s2);
  EXPECT_THROW(MeasureSet({clips[0].Slice(0, 50)}), std::invalid_argument);
}

TEST(CapturedSets, AgreeWithThemselvesAndNotWithEachOther) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<MotionClip> halves[2], elderly, shaken;
  std::vector<StyledWindows> styled;
  int index = 0;
  for (const LoadedClip& loaded : LoadDataset({testing::SharedData() / "bnr" / "dataset-2" / "walk"}).clips) {
    const MotionClip& clip = loaded.clip;
    if (clip.style != "normal" && clip.style != "elderly") continue;
    styled.push_back({clip.style, PoseWindows(PrepareEvaluation(clip))});
    if (clip.style == "elderly") elderly.push_back(clip);
    if (clip.style != "normal") continue;
    halves[index++ % 2].push_back(clip);
    shaken.push_back(clip);
    for (int f = 0; f < clip.frame_count(); f += 4) shaken.back().root_positions()(1, f) += 0.005;
  }
  ASSERT_EQ(index, 20);
  EXPECT_LT(CompareSets(halves[0], halves[1]).frechet_ratio, 2.0);
  EXPECT_GT(CompareSets(elderly, halves[1]).frechet_ratio, 10);

  const SetQuality a = MeasureSet(halves[0]), b = MeasureSet(halves[1]), worse = MeasureSet(shaken);
  EXPECT_NEAR(a.contact_distance_m / b.contact_distance_m, 1, 0.15);
  EXPECT_NEAR(a.foot_skate_cm_s / b.foot_skate_cm_s, 1, 0.2);
  EXPECT_NEAR(a.acceleration_p999_m_s2 / b.acceleration_p999_m_s2, 1, 0.2);
  EXPECT_GE(a.min_knee_flexion_deg, -0.01);
  EXPECT_GT(worse.contact_distance_m, 1.1 * b.contact_distance_m);
  EXPECT_GT(worse.mean_jerk_m_s3, 2 * b.mean_jerk_m_s3);
  EXPECT_GE(CrossValidateStyles(styled).accuracy, 0.97);
}

}  // namespace
}  // namespace morphograph
