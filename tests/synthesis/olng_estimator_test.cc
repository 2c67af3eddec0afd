#include "synthesis/sensors/olng_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "datasets/resample.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/support/olng_setting.h"

namespace morphograph {
namespace {

TEST(OlngEstimator, FindsAMotionThatTheBaseHolds) {
  for (const OlngPose pose : {OlngPose::kNearest, OlngPose::kWeightedMean, OlngPose::kEnergy}) {
    OlngOptions options;
    options.pose = pose;
    options.paths = 4;
    const ReconstructionQuality quality = CompareWithTruth(*testing::OlngShared().base, testing::RunOlng(testing::OlngShared().Read(testing::OlngShared().known), options), testing::OlngShared().known);
    EXPECT_LT(quality.position_rms_cm, pose == OlngPose::kNearest ? 0.2 : 1.5) << static_cast<int>(pose);
  }
}

TEST(OlngEstimator, ComesNearerToAnUnknownWalkThanTheNearestNeighbour) {
  const Eigen::MatrixXd readings = testing::OlngShared().Read(testing::OlngShared().test);
  OlngOptions baseline;
  baseline.pose = OlngPose::kNearest;
  const ReconstructionQuality nearest = CompareWithTruth(*testing::OlngShared().base, testing::RunOlng(readings, baseline), testing::OlngShared().test);
  for (const PriorKind kind : {PriorKind::kKernel, PriorKind::kGaussian}) {
    OlngOptions options;
    options.energy.kind = kind;
    const std::vector<BasePose> poses = testing::RunOlng(readings, options);
    const ReconstructionQuality quality = CompareWithTruth(*testing::OlngShared().base, poses, testing::OlngShared().test);
    EXPECT_LT(quality.position_rms_cm, 0.9 * nearest.position_rms_cm) << static_cast<int>(kind);
    EXPECT_LT(quality.jerk_ratio, nearest.jerk_ratio) << static_cast<int>(kind);
    // It goes as far as the walk does, and the last way it went was forwards.
    const MotionClip clip = testing::OlngShared().base->Assemble(poses);
    const auto length = [](const MotionClip& of) { return (of.root_positions().rightCols<1>() - of.root_positions().leftCols<1>()).norm(); };
    EXPECT_NEAR(length(clip) / length(testing::OlngShared().test), 1, 0.1);
  }
}

// What the README says of both: the published kernels are there to be asked for.
TEST(OlngEstimator, TakesNormalDistributionsUnlessAskedForKernels) {
  OlngOptions normal, kernels;
  normal.energy.kind = PriorKind::kGaussian;
  kernels.energy.kind = PriorKind::kKernel;
  const Eigen::MatrixXd readings = testing::OlngShared().Read(testing::OlngShared().test).leftCols(20);
  EXPECT_EQ(testing::RunOlng(readings, {}).back().rotations, testing::RunOlng(readings, normal).back().rotations);
  EXPECT_NE(testing::RunOlng(readings, {}).back().rotations, testing::RunOlng(readings, kernels).back().rotations);
}

TEST(OlngEstimator, PosesDependOnReadingsUntilNowOnly) {
  OlngOptions options;
  const Eigen::MatrixXd readings = testing::OlngShared().Read(testing::OlngShared().test);
  const std::vector<BasePose> whole = testing::RunOlng(readings, options), again = testing::RunOlng(readings, options), part = testing::RunOlng(readings.leftCols(40), options);
  ASSERT_EQ(part.size(), 40U);
  for (std::size_t f = 0; f < whole.size(); ++f) {
    ASSERT_TRUE(whole[f].rotations.allFinite() && whole[f].step.allFinite());
    EXPECT_EQ(whole[f].rotations, again[f].rotations);
    if (f >= part.size()) continue;
    EXPECT_EQ(whole[f].rotations, part[f].rotations) << f;
  }
}

TEST(OlngEstimator, AFasterWalkGoesFaster) {
  // The same poses a quarter faster: readings change with the square of it, and the base has no such walk at that tempo.
  const MotionClip& known = testing::OlngShared().known;
  MotionClip faster(known.shared_skeleton(), 30 * 1.25, known.frame_count());
  for (int f = 0; f < known.frame_count(); ++f) std::copy_n(known.rotations(f), known.joint_count(), &faster.rotation(f, 0));
  faster.root_positions() = known.root_positions();
  const std::vector<BasePose> poses = testing::RunOlng(testing::OlngShared().Read(faster), {});
  const MotionClip clip = testing::OlngShared().base->Assemble(poses);
  const auto length = [](const MotionClip& of) { return (of.root_positions().rightCols<1>() - of.root_positions().leftCols<1>()).norm(); };
  EXPECT_NEAR(length(clip) / length(known), 1, 0.12);
}

TEST(OlngEstimator, CopiesOfOtherTemposFindASlowerWalk) {
  const testing::OlngSetting& shared = testing::OlngShared();
  std::vector<MotionClip> walks = testing::OlngWalks();
  walks.erase(walks.begin() + 4);
  MotionBaseOptions with_copies;
  with_copies.tempos = {0.85};
  const auto retimed = std::make_shared<MotionBase>(walks, shared.base->sensors(), with_copies);
  EXPECT_EQ(retimed->own_tempo_frames(), shared.base->frame_count());
  EXPECT_EQ(shared.base->own_tempo_frames(), shared.base->frame_count());
  EXPECT_NEAR(static_cast<double>(retimed->frame_count()) / static_cast<double>(shared.base->frame_count()), 1 + 1 / 0.85, 0.02);
  // As many paths, and neighbours in proportion.
  const OlngModel plain(shared.base, {}), copied(retimed, {});
  EXPECT_EQ(copied.options().paths, plain.options().paths);
  EXPECT_GT(copied.options().neighbours, 2 * plain.options().neighbours);

  const MotionClip slower = Resample(Retimed(shared.test, 0.8 * 30), 30);
  const Eigen::MatrixXd readings = shared.Read(slower);
  OlngEstimator estimator(std::make_shared<OlngModel>(retimed, OlngOptions()));
  std::vector<BasePose> poses;
  for (Eigen::Index f = 0; f < readings.cols(); ++f) poses.push_back(estimator.Next(readings.col(f)));
  const double with = CompareWithTruth(*retimed, poses, slower).position_rms_cm, without = CompareWithTruth(*shared.base, testing::RunOlng(readings, {}), slower).position_rms_cm;
  EXPECT_LT(with, 0.9 * without) << with << " and " << without;
}

TEST(OlngEstimator, TheFirstPosesOfAStreamHardlyBindTheNext) {
  // Readings that begin with two frames of another moment of the walk: a pose that goes on from there as if it were sure of it stays behind.
  const Eigen::MatrixXd readings = testing::OlngShared().Read(testing::OlngShared().known);
  Eigen::MatrixXd torn = readings.middleCols(20, 40);
  torn.leftCols(2) = readings.middleCols(40, 2);
  const std::vector<BasePose> after_wrong = testing::RunOlng(torn, {});
  const std::vector<BasePose> truth = PosesOf(*testing::OlngShared().base, testing::OlngShared().known);
  const auto off_cm = [&](std::size_t f) {
    const Eigen::VectorXd off = MeasuredPositions(*testing::OlngShared().base, after_wrong[f].rotations) - MeasuredPositions(*testing::OlngShared().base, truth[20 + f].rotations);
    return 100 * std::sqrt(off.squaredNorm() / static_cast<double>(off.size() / 3));
  };
  EXPECT_GT(off_cm(1), 5);
  EXPECT_LT(off_cm(3), 0.7);
}

TEST(OlngEstimator, RefusesReadingsThatAreNone) {
  OlngEstimator estimator(std::make_shared<OlngModel>(testing::OlngShared().base, OlngOptions()));
  EXPECT_THROW(estimator.Next(Eigen::VectorXd::Zero(11)), std::invalid_argument);
  EXPECT_THROW(estimator.Next(Eigen::VectorXd::Constant(12, std::nan(""))), std::invalid_argument);
  OlngOptions wrong;
  wrong.neighbours = -1;
  EXPECT_THROW(OlngModel(testing::OlngShared().base, wrong), std::invalid_argument);
  const auto without = std::make_shared<MotionBase>(testing::OlngWalks(), std::vector<Placement>(), MotionBaseOptions());
  EXPECT_THROW(OlngModel(without, {}), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
