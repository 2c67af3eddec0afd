#include "synthesis/sensors/olng_recording.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "datasets/resample.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/support/olng_setting.h"

namespace morphograph {
namespace {

TEST(OlngRecording, LooksAheadAndIsNoLoser) {
  const auto model = std::make_shared<OlngModel>(testing::OlngShared().base, OlngOptions());
  // From the middle of a step on: all walks begin alike.
  const MotionClip truth = testing::OlngShared().test.Slice(28, testing::OlngShared().test.frame_count() - 28);
  const Eigen::MatrixXd readings = testing::OlngShared().Read(truth);
  const std::vector<BasePose> whole = ReconstructRecording(model, readings), again = ReconstructRecording(model, readings), stream = testing::RunOlng(readings, {});
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(readings.cols()));
  for (std::size_t f = 0; f < whole.size(); ++f) EXPECT_EQ(whole[f].rotations, again[f].rotations);
  const ReconstructionQuality ahead = CompareWithTruth(*testing::OlngShared().base, whole, truth), causal = CompareWithTruth(*testing::OlngShared().base, stream, truth);
  EXPECT_LT(ahead.position_rms_cm, causal.position_rms_cm);
  // Where a stream can but guess, what follows tells.
  EXPECT_LT(ahead.frame_rms_cm.front(), causal.frame_rms_cm.front());
  // The last frame has no future: the same paths, seen from a pose before that differs a little.
  EXPECT_NEAR(ahead.frame_rms_cm.back(), causal.frame_rms_cm.back(), 0.1);
}

TEST(OlngRecording, FavoursNoDirectionOfTime) {
  // Accelerations are the same when time goes the other way.
  std::vector<MotionClip> walks = testing::OlngWalks();
  const MotionClip test = walks[4];
  walks.erase(walks.begin() + 4);
  for (MotionClip& walk : walks) walk = Reversed(walk);
  const auto base = std::make_shared<MotionBase>(walks, testing::OlngShared().base->sensors(), MotionBaseOptions());
  const Eigen::MatrixXd readings = testing::OlngShared().Read(test);
  ASSERT_LT(readings.cols(), 256);  // one block: all that comes is known, as all that was
  for (const PriorKind kind : {PriorKind::kGaussian, PriorKind::kKernel}) {
    OlngOptions options;
    options.energy.kind = kind;
    const std::vector<BasePose> poses = ReconstructRecording(std::make_shared<OlngModel>(testing::OlngShared().base, options), readings);
    const std::vector<BasePose> backwards = ReconstructRecording(std::make_shared<OlngModel>(base, options), readings.rowwise().reverse());
    double farthest = 0, moved = 0;
    for (std::size_t f = 0; f < poses.size(); ++f) {
      farthest = std::max(farthest, (poses[f].rotations - backwards[poses.size() - 1 - f].rotations).cwiseAbs().maxCoeff());
      moved = std::max(moved, (poses[f].rotations - poses[0].rotations).cwiseAbs().maxCoeff());
    }
    EXPECT_GT(moved, 0.3);
    EXPECT_LT(farthest, 1e-5);  // rad
  }
}

// Blocks are seams that must not show. Walks of all speeds, one after the other: what comes next is not what was.
TEST(OlngRecording, GoesOverItsBlocksWithoutASeam) {
  const auto model = std::make_shared<OlngModel>(testing::OlngShared().base, OlngOptions());
  std::vector<Eigen::MatrixXd> walks;
  Eigen::Index frames = 0;
  for (const MotionClip& walk : testing::OlngWalks()) frames += walks.emplace_back(testing::OlngShared().Read(walk)).cols();
  ASSERT_GT(frames, 800);
  Eigen::MatrixXd readings(walks.front().rows(), frames);
  for (Eigen::Index at = 0; const Eigen::MatrixXd& walk : walks) readings.middleCols(at, walk.cols()) = walk, at += walk.cols();
  const std::vector<BasePose> whole = ReconstructRecording(model, readings);
  // From another reading on, the blocks begin elsewhere.
  const Eigen::Index cut = 150;
  const std::vector<BasePose> later = ReconstructRecording(model, readings.rightCols(frames - cut));
  double farthest = 0;
  for (std::size_t f = 150; f < later.size(); ++f) farthest = std::max(farthest, (later[f].rotations - whole[f + cut].rotations).cwiseAbs().maxCoeff());
  EXPECT_LT(farthest, 1e-4);  // rad; what the look-ahead leaves out
}

TEST(OlngRecording, RefusesReadingsThatAreNone) {
  const auto model = std::make_shared<OlngModel>(testing::OlngShared().base, OlngOptions());
  EXPECT_THROW(ReconstructRecording(model, Eigen::MatrixXd::Zero(11, 5)), std::invalid_argument);
  EXPECT_THROW(ReconstructRecording(model, Eigen::MatrixXd::Constant(12, 5, std::nan(""))), std::invalid_argument);
  EXPECT_TRUE(ReconstructRecording(model, Eigen::MatrixXd(12, 0)).empty());
}

}  // namespace
}  // namespace morphograph
