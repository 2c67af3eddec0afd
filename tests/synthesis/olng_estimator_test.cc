#include "synthesis/sensors/olng_estimator.h"
#include "synthesis/sensors/olng_recording.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "datasets/resample.h"
#include "datasets/synthetic_gait.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

// Walks of several speeds on one skeleton.
std::vector<MotionClip> OlngWalks() {
  std::vector<MotionClip> walks;
  for (std::uint64_t i = 0; i < 9; ++i) {
    SyntheticGaitOptions options;
    options.seed = i + 1;
    options.frame_rate_hz = 30;
    options.steps = 8;
    options.speed_m_s = 1.0 + 0.08 * static_cast<double>(i);
    options.stop_standing = false;
    walks.push_back(GenerateGait(options));
    if (i > 0) {
      MotionClip shared(walks.front().shared_skeleton(), 30, walks.back().frame_count());
      for (int f = 0; f < shared.frame_count(); ++f) std::copy_n(walks.back().rotations(f), shared.joint_count(), &shared.rotation(f, 0));
      shared.root_positions() = walks.back().root_positions();
      walks.back() = shared;
    }
  }
  return walks;
}

// All walks but one, and that one.
struct OlngSetting {
  OlngSetting() {
    std::vector<MotionClip> walks = OlngWalks();
    test = walks[4];
    walks.erase(walks.begin() + 4);
    base = std::make_shared<MotionBase>(walks, PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"}), MotionBaseOptions());
    known = walks[3];
  }
  Eigen::MatrixXd Read(const MotionClip& clip) const { return VirtualAccelerations(clip, base->sensors(), 30).values; }
  MotionClip test, known;
  std::shared_ptr<const MotionBase> base;
};

const OlngSetting& OlngShared() {
  static const OlngSetting setting;
  return setting;
}

std::vector<BasePose> RunOlng(const Eigen::MatrixXd& readings, const OlngOptions& options) {
  OlngEstimator estimator(std::make_shared<OlngModel>(OlngShared().base, options));
  std::vector<BasePose> poses;
  for (Eigen::Index f = 0; f < readings.cols(); ++f) poses.push_back(estimator.Next(readings.col(f)));
  return poses;
}

// Random targets of the sizes that the base asks for.
NeighbourhoodTargets RandomTargets(std::mt19937_64& rng) {
  const MotionBase& base = *OlngShared().base;
  const Eigen::Index rotations = base.rotations().rows(), positions = base.positions().rows();
  NeighbourhoodTargets targets;
  targets.weights = testing::RandomNormal(20, 1, rng).cwiseAbs();
  targets.weights /= targets.weights.sum();
  targets.poses = 0.1 * testing::RandomNormal(rotations, 20, rng);
  const Eigen::VectorXd about = MeasuredPositions(base, targets.poses.col(0));
  targets.motion = (0.03 * testing::RandomNormal(positions, 20, rng)).colwise() + about;
  targets.smooth = (0.03 * testing::RandomNormal(positions, 20, rng)).colwise() + about;
  targets.controlled = {2, 5, 3};
  targets.control = 0.2 * testing::RandomNormal(9, 20, rng);
  targets.inertial = about;
  return targets;
}

TEST(NeighbourhoodEnergy, GradientsAreThoseOfDifferences) {
  std::mt19937_64 rng(17);
  bool squared = false;
  for (const PriorKind kind : {PriorKind::kKernel, PriorKind::kGaussian, PriorKind::kGaussian, PriorKind::kGaussianLeastAcceleration}) {
    NeighbourhoodEnergyOptions options;
    options.kind = kind;
    options.squared = squared = !squared;  // of the two normal distributions one
    const NeighbourhoodEnergy energy(*OlngShared().base, RandomTargets(rng), options);
    ASSERT_GT(energy.dims(), 5);
    const Eigen::VectorXd at = 0.3 * testing::RandomNormal(energy.dims(), 1, rng);
    Eigen::VectorXd gradient;
    energy.Energy(at, &gradient);
    for (Eigen::Index i = 0; i < energy.dims(); ++i) {
      const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(energy.dims(), i);
      const double difference = (energy.Energy(at + step, nullptr) - energy.Energy(at - step, nullptr)) / 2e-6;
      EXPECT_NEAR(gradient[i], difference, 1e-5 * (1 + gradient.cwiseAbs().maxCoeff())) << static_cast<int>(kind) << " " << i;
    }
  }
}

TEST(NeighbourhoodEnergy, PositionsPullBackToRotations) {
  std::mt19937_64 rng(19);
  const MotionBase& base = *OlngShared().base;
  const Eigen::VectorXd at = 0.5 * testing::RandomNormal(base.rotations().rows(), 1, rng);
  const Eigen::VectorXd direction = testing::RandomNormal(base.positions().rows(), 1, rng);
  const Eigen::VectorXd gradient = PullBack(base, at, direction);
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(at.size(), i);
    const double difference = direction.dot(MeasuredPositions(base, at + step) - MeasuredPositions(base, at - step)) / 2e-6;
    EXPECT_NEAR(gradient[i], difference, 1e-6) << i;
  }
}

TEST(NeighbourhoodEnergy, MinimisingEndsWhereTheSlopeDoes) {
  std::mt19937_64 rng(23);
  for (const PriorKind kind : {PriorKind::kKernel, PriorKind::kGaussian, PriorKind::kGaussianLeastAcceleration}) {
    NeighbourhoodEnergyOptions options;
    options.kind = kind;
    options.max_iterations = 200;
    const NeighbourhoodEnergy energy(*OlngShared().base, RandomTargets(rng), options);
    const Eigen::VectorXd start = 0.3 * testing::RandomNormal(energy.dims(), 1, rng);
    const Eigen::VectorXd found = energy.Coordinates(energy.Minimise(energy.Rotations(start)));
    Eigen::VectorXd first, last;
    EXPECT_LT(energy.Energy(found, &last), energy.Energy(start, &first));
    EXPECT_LT(last.norm(), 0.05 * first.norm()) << static_cast<int>(kind);
  }
}

TEST(NeighbourhoodEnergy, KernelsHoldToTheLargerOfTwoClustersAndNormalDistributionsToTheMiddle) {
  // Tautges, Fig. 4.
  const Eigen::MatrixXd samples = (Eigen::RowVectorXd(5) << -1.02, -1, -0.98, 1, 1.02).finished();
  const Eigen::VectorXd weights = Eigen::VectorXd::Constant(5, 0.2);
  const KernelPrior kernel(samples, weights, Eigen::VectorXd::Constant(5, 1e-4));
  const GaussianPrior normal(samples, weights, 0.01, false);
  const auto at = [](double y) -> Eigen::VectorXd { return Eigen::VectorXd::Constant(1, y); };
  EXPECT_LT(kernel.Energy(at(-1), 1, nullptr), kernel.Energy(at(1), 1, nullptr));
  EXPECT_LT(kernel.Energy(at(1), 1, nullptr), kernel.Energy(at(0), 1, nullptr)) << "each cluster has a minimum of its own";
  EXPECT_LT(normal.Energy(at(-0.2), 1, nullptr), normal.Energy(at(-1), 1, nullptr));
}

TEST(OlngEstimator, FindsAMotionThatTheBaseHolds) {
  for (const OlngPose pose : {OlngPose::kNearest, OlngPose::kWeightedMean, OlngPose::kEnergy}) {
    OlngOptions options;
    options.pose = pose;
    options.paths = 4;
    const ReconstructionQuality quality = CompareWithTruth(*OlngShared().base, RunOlng(OlngShared().Read(OlngShared().known), options), OlngShared().known);
    EXPECT_LT(quality.position_rms_cm, pose == OlngPose::kNearest ? 0.2 : 1.5) << static_cast<int>(pose);
  }
}

TEST(OlngEstimator, ComesNearerToAnUnknownWalkThanTheNearestNeighbour) {
  const Eigen::MatrixXd readings = OlngShared().Read(OlngShared().test);
  OlngOptions baseline;
  baseline.pose = OlngPose::kNearest;
  const ReconstructionQuality nearest = CompareWithTruth(*OlngShared().base, RunOlng(readings, baseline), OlngShared().test);
  for (const PriorKind kind : {PriorKind::kKernel, PriorKind::kGaussian}) {
    OlngOptions options;
    options.energy.kind = kind;
    const std::vector<BasePose> poses = RunOlng(readings, options);
    const ReconstructionQuality quality = CompareWithTruth(*OlngShared().base, poses, OlngShared().test);
    EXPECT_LT(quality.position_rms_cm, 0.9 * nearest.position_rms_cm) << static_cast<int>(kind);
    EXPECT_LT(quality.jerk_ratio, nearest.jerk_ratio) << static_cast<int>(kind);
    // It goes as far as the walk does, and the last way it went was forwards.
    const MotionClip clip = OlngShared().base->Assemble(poses);
    const auto length = [](const MotionClip& of) { return (of.root_positions().rightCols<1>() - of.root_positions().leftCols<1>()).norm(); };
    EXPECT_NEAR(length(clip) / length(OlngShared().test), 1, 0.1);
  }
}

// What the README says of both: the published kernels are there to be asked for.
TEST(OlngEstimator, TakesNormalDistributionsUnlessAskedForKernels) {
  OlngOptions normal, kernels;
  normal.energy.kind = PriorKind::kGaussian;
  kernels.energy.kind = PriorKind::kKernel;
  const Eigen::MatrixXd readings = OlngShared().Read(OlngShared().test).leftCols(20);
  EXPECT_EQ(RunOlng(readings, {}).back().rotations, RunOlng(readings, normal).back().rotations);
  EXPECT_NE(RunOlng(readings, {}).back().rotations, RunOlng(readings, kernels).back().rotations);
}

TEST(OlngEstimator, PosesDependOnReadingsUntilNowOnly) {
  OlngOptions options;
  const Eigen::MatrixXd readings = OlngShared().Read(OlngShared().test);
  const std::vector<BasePose> whole = RunOlng(readings, options), again = RunOlng(readings, options), part = RunOlng(readings.leftCols(40), options);
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
  const MotionClip& known = OlngShared().known;
  MotionClip faster(known.shared_skeleton(), 30 * 1.25, known.frame_count());
  for (int f = 0; f < known.frame_count(); ++f) std::copy_n(known.rotations(f), known.joint_count(), &faster.rotation(f, 0));
  faster.root_positions() = known.root_positions();
  const std::vector<BasePose> poses = RunOlng(OlngShared().Read(faster), {});
  const MotionClip clip = OlngShared().base->Assemble(poses);
  const auto length = [](const MotionClip& of) { return (of.root_positions().rightCols<1>() - of.root_positions().leftCols<1>()).norm(); };
  EXPECT_NEAR(length(clip) / length(known), 1, 0.12);
}

TEST(OlngEstimator, CopiesOfOtherTemposFindASlowerWalk) {
  const OlngSetting& shared = OlngShared();
  std::vector<MotionClip> walks = OlngWalks();
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
  const double with = CompareWithTruth(*retimed, poses, slower).position_rms_cm, without = CompareWithTruth(*shared.base, RunOlng(readings, {}), slower).position_rms_cm;
  EXPECT_LT(with, 0.9 * without) << with << " and " << without;
}

TEST(OlngEstimator, TheFirstPosesOfAStreamHardlyBindTheNext) {
  // Readings that begin with two frames of another moment of the walk: a pose that goes on from there as if it were sure of it stays behind.
  const Eigen::MatrixXd readings = OlngShared().Read(OlngShared().known);
  Eigen::MatrixXd torn = readings.middleCols(20, 40);
  torn.leftCols(2) = readings.middleCols(40, 2);
  const std::vector<BasePose> after_wrong = RunOlng(torn, {});
  const std::vector<BasePose> truth = PosesOf(*OlngShared().base, OlngShared().known);
  const auto off_cm = [&](std::size_t f) {
    const Eigen::VectorXd off = MeasuredPositions(*OlngShared().base, after_wrong[f].rotations) - MeasuredPositions(*OlngShared().base, truth[20 + f].rotations);
    return 100 * std::sqrt(off.squaredNorm() / static_cast<double>(off.size() / 3));
  };
  EXPECT_GT(off_cm(1), 5);
  EXPECT_LT(off_cm(3), 0.7);
}

TEST(OlngRecording, LooksAheadAndIsNoLoser) {
  const auto model = std::make_shared<OlngModel>(OlngShared().base, OlngOptions());
  // From the middle of a step on: all walks begin alike.
  const MotionClip truth = OlngShared().test.Slice(28, OlngShared().test.frame_count() - 28);
  const Eigen::MatrixXd readings = OlngShared().Read(truth);
  const std::vector<BasePose> whole = ReconstructRecording(model, readings), again = ReconstructRecording(model, readings), stream = RunOlng(readings, {});
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(readings.cols()));
  for (std::size_t f = 0; f < whole.size(); ++f) EXPECT_EQ(whole[f].rotations, again[f].rotations);
  const ReconstructionQuality ahead = CompareWithTruth(*OlngShared().base, whole, truth), causal = CompareWithTruth(*OlngShared().base, stream, truth);
  EXPECT_LT(ahead.position_rms_cm, causal.position_rms_cm);
  // Where a stream can but guess, what follows tells.
  EXPECT_LT(ahead.frame_rms_cm.front(), causal.frame_rms_cm.front());
  // The last frame has no future: the same paths, seen from a pose before that differs a little.
  EXPECT_NEAR(ahead.frame_rms_cm.back(), causal.frame_rms_cm.back(), 0.1);
}

MotionClip PlayedBackwards(const MotionClip& clip) {
  MotionClip backwards(clip.shared_skeleton(), clip.frame_rate_hz(), clip.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) std::copy_n(clip.rotations(clip.frame_count() - 1 - f), clip.joint_count(), &backwards.rotation(f, 0));
  backwards.root_positions() = clip.root_positions().rowwise().reverse();
  return backwards;
}

TEST(OlngRecording, FavoursNoDirectionOfTime) {
  // Accelerations are the same when time goes the other way.
  std::vector<MotionClip> walks = OlngWalks();
  const MotionClip test = walks[4];
  walks.erase(walks.begin() + 4);
  for (MotionClip& walk : walks) walk = PlayedBackwards(walk);
  const auto base = std::make_shared<MotionBase>(walks, OlngShared().base->sensors(), MotionBaseOptions());
  const Eigen::MatrixXd readings = OlngShared().Read(test);
  ASSERT_LT(readings.cols(), 256);  // one block: all that comes is known, as all that was
  for (const PriorKind kind : {PriorKind::kGaussian, PriorKind::kKernel}) {
    OlngOptions options;
    options.energy.kind = kind;
    const std::vector<BasePose> poses = ReconstructRecording(std::make_shared<OlngModel>(OlngShared().base, options), readings);
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

TEST(PathPoser, RefusesPathsThatAreNone) {
  const auto model = std::make_shared<OlngModel>(OlngShared().base, OlngOptions());
  PathPoser poser(model);
  const Eigen::VectorXd reading = OlngShared().Read(OlngShared().known).col(0);
  EXPECT_THROW(poser.Next(reading, {}), std::invalid_argument);
  EXPECT_THROW(poser.Next(reading, {{.frame = -1}}), std::invalid_argument);
  EXPECT_THROW(poser.Next(reading, {{.frame = static_cast<int>(model->base().frame_count())}}), std::invalid_argument);
  EXPECT_THROW(poser.Next(reading.head(9), {{.frame = 0}}), std::invalid_argument);
  // The first and the last frame of the base: nothing comes before, or after.
  for (const TimeDirection direction : {TimeDirection::kForwards, TimeDirection::kBackwards}) {
    PathPoser at_the_ends(model, direction);
    for (int n = 0; n < 3; ++n)
      EXPECT_TRUE(at_the_ends.Next(reading, {{.frame = 0}, {.frame = static_cast<int>(model->base().frame_count()) - 1}}).rotations.allFinite());
  }
  OlngOptions nearest;
  nearest.pose = OlngPose::kNearest;
  EXPECT_THROW(PathPoser(std::make_shared<OlngModel>(OlngShared().base, nearest)), std::invalid_argument);
}

// Blocks are seams that must not show. Walks of all speeds, one after the other: what comes next is not what was.
TEST(OlngRecording, GoesOverItsBlocksWithoutASeam) {
  const auto model = std::make_shared<OlngModel>(OlngShared().base, OlngOptions());
  std::vector<Eigen::MatrixXd> walks;
  Eigen::Index frames = 0;
  for (const MotionClip& walk : OlngWalks()) frames += walks.emplace_back(OlngShared().Read(walk)).cols();
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
  const auto model = std::make_shared<OlngModel>(OlngShared().base, OlngOptions());
  EXPECT_THROW(ReconstructRecording(model, Eigen::MatrixXd::Zero(11, 5)), std::invalid_argument);
  EXPECT_THROW(ReconstructRecording(model, Eigen::MatrixXd::Constant(12, 5, std::nan(""))), std::invalid_argument);
  EXPECT_TRUE(ReconstructRecording(model, Eigen::MatrixXd(12, 0)).empty());
}

TEST(OlngEstimator, RefusesReadingsThatAreNone) {
  OlngEstimator estimator(std::make_shared<OlngModel>(OlngShared().base, OlngOptions()));
  EXPECT_THROW(estimator.Next(Eigen::VectorXd::Zero(11)), std::invalid_argument);
  EXPECT_THROW(estimator.Next(Eigen::VectorXd::Constant(12, std::nan(""))), std::invalid_argument);
  OlngOptions wrong;
  wrong.neighbours = -1;
  EXPECT_THROW(OlngModel(OlngShared().base, wrong), std::invalid_argument);
  const auto without = std::make_shared<MotionBase>(OlngWalks(), std::vector<Placement>(), MotionBaseOptions());
  EXPECT_THROW(OlngModel(without, {}), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
