#include "synthesis/sensors/rbf_estimator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/support/random_matrix.h"
#include "tests/synthesis/small_base.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

using testing::SmallBase;
using testing::UnseenWalk;

RbfOptions SmallOptions() {
  RbfOptions options;
  options.clusters.max_clusters = 16;
  options.clusters.fit_frames = 600;
  return options;
}

std::shared_ptr<const RbfModel> SmallModel() {
  static const auto model = std::make_shared<const RbfModel>(SmallBase(), SmallOptions());
  return model;
}

TEST(PoseChannels, ComeBackAndMeasureHowFarJointsAreApart) {
  const MotionBase& base = SmallBase();
  const PoseChannels channels(base);
  const BasePose pose = base.Pose(17), back = channels.Pose(channels.Vector(pose));
  EXPECT_TRUE(back.rotations.isApprox(pose.rotations, 1e-12));
  EXPECT_TRUE(back.step.isApprox(pose.step, 1e-12));
  EXPECT_NEAR(back.height_m, pose.height_m, 1e-12);
  EXPECT_TRUE(channels.Vectors(base).col(17).cast<double>().isApprox(channels.Vector(pose), 1e-6));
  // Distances of vectors follow those of joints: neither a third, nor three times as large, anywhere along a walk.
  for (const Eigen::Index other : {20, 25, 30, 100}) {
    const double joints = std::sqrt((base.positions().col(17) - base.positions().col(other)).squaredNorm() / static_cast<float>(base.measured_joints().size()));
    const double vectors = (channels.Vector(base.Pose(17)) - channels.Vector(base.Pose(other))).norm();
    EXPECT_GT(vectors, joints / 3) << other;
    EXPECT_LT(vectors, joints * 3) << other;
  }
}

TEST(PoseReduction, PcaKeepsTheLeadingVariance) {
  std::mt19937_64 rng(3);
  const Eigen::MatrixXf poses = (testing::RandomNormal(20, 4, rng) * testing::RandomNormal(4, 300, rng)).cast<float>();
  PoseReductionOptions options;
  options.components = 4;
  const PoseReduction reduction(poses, options);
  const Eigen::MatrixXf coordinates = reduction.Coordinates(poses);
  EXPECT_TRUE(reduction.Pose(coordinates.col(7).cast<double>()).isApprox(poses.col(7).cast<double>(), 1e-4));
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(coordinates.row(c).norm() / std::sqrt(300.f), reduction.spreads()[c], 1e-3);
  EXPECT_GE(reduction.spreads()[0], reduction.spreads()[3]);
}

TEST(PoseReduction, LleLeadsBackNearToPosesOfACurve) {
  // A bent curve in 12 dimensions: one coordinate says where on it a pose is.
  Eigen::MatrixXf poses(12, 600);
  for (int i = 0; i < 600; ++i) {
    const float t = 1.5f * static_cast<float>(i) / 600;
    for (int c = 0; c < 12; ++c) poses(c, i) = std::sin(t * (1 + 0.1f * static_cast<float>(c)) + static_cast<float>(c));
  }
  PoseReductionOptions options;
  options.kind = ReductionKind::kLle;
  options.components = 1;
  options.samples = 300;
  options.neighbours = 12;  // on a curve; poses have room for more
  const PoseReduction reduction(poses, options);
  const Eigen::MatrixXf coordinates = reduction.Coordinates(poses);
  for (const int i : {50, 301, 555}) EXPECT_LT((reduction.Pose(coordinates.col(i).cast<double>()) - poses.col(i).cast<double>()).norm(), 0.05) << i;
}

TEST(RadialBasisMap, FollowsASmoothFunctionBetweenItsSamples) {
  std::mt19937_64 rng(5);
  const Eigen::MatrixXf inputs = testing::RandomNormal(2, 2000, rng).cast<float>();
  Eigen::MatrixXf outputs(2, 2000);
  outputs.row(0) = (inputs.row(0).array() * 1.5f).sin() + inputs.row(1).array();
  outputs.row(1) = inputs.row(0).array() * inputs.row(1).array();
  RadialBasisOptions options;
  options.ridge = 1e-6;
  const RadialBasisMap map(inputs, outputs, options);
  const Eigen::Vector2f x(0.3f, -0.4f);
  EXPECT_NEAR(map.Value(x)[0], std::sin(0.45f) - 0.4f, 0.02);
  EXPECT_NEAR(map.Value(x)[1], -0.12f, 0.02);
  EXPECT_LT(map.residual().maxCoeff(), 0.1f);
}

TEST(RadialBasisMap, DerivativeIsTheSlopeOfItsValue) {
  std::mt19937_64 rng(6);
  const Eigen::MatrixXf inputs = testing::RandomNormal(3, 500, rng).cast<float>(), outputs = testing::RandomNormal(2, 500, rng).cast<float>();
  const RadialBasisMap map(inputs, outputs, {});
  const Eigen::Vector3f x(0.2f, -0.5f, 0.7f);
  Eigen::MatrixXf derivative;
  EXPECT_TRUE(map.Value(x, &derivative).isApprox(map.Value(x)));
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3f step = 1e-2f * Eigen::Vector3f::Unit(i);
    const Eigen::VectorXf slope = (map.Value(x + step) - map.Value(x - step)) / 2e-2f;
    EXPECT_LT((slope - derivative.col(i)).norm(), 2e-3f) << i;
  }
}

TEST(RadialBasisMap, TakesOneSampleAndEqualSamples) {
  const Eigen::MatrixXf inputs = Eigen::MatrixXf::Constant(3, 9, 2), outputs = Eigen::MatrixXf::Constant(1, 9, 5);
  EXPECT_NEAR(RadialBasisMap(inputs, outputs, {}).Value(inputs.col(0))[0], 5, 1e-3);
  EXPECT_NEAR(RadialBasisMap(inputs.leftCols(1), outputs.leftCols(1), {}).Value(inputs.col(0))[0], 5, 1e-3);
  EXPECT_THROW(RadialBasisMap(inputs, outputs.leftCols(3), {}), std::invalid_argument);
}

TEST(PoseClusters, NumberHasTheLeastDescriptionLength) {
  const PoseClusters& clusters = SmallModel()->clusters;
  const auto best = std::min_element(clusters.candidates.begin(), clusters.candidates.end(),
                                     [](const auto& a, const auto& b) { return a.description_length < b.description_length; });
  EXPECT_EQ(clusters.count(), best->clusters);
  EXPECT_GT(clusters.count(), 2);
  EXPECT_EQ(*std::max_element(clusters.of_frame.begin(), clusters.of_frame.end()), clusters.count() - 1);
  for (int k = 0; k < clusters.count(); ++k) EXPECT_NEAR(clusters.transitions.col(k).sum(), 1, 1e-5);
}

TEST(ClusterFilter, ReadingsSoFarTellMoreThanTheLastOne) {
  const MotionBase& base = SmallBase();
  const PoseClusters& clusters = SmallModel()->clusters;
  ClusterFilter filtered(clusters, ClusterChoice::kFiltered, 0.2), nearest(clusters, ClusterChoice::kNearestMean, 0.2);
  std::mt19937_64 rng(8);
  boost::random::normal_distribution<float> noise(0, 2);
  int right = 0, nearest_right = 0, frames = 0;
  for (Eigen::Index f = 0; f < base.frame_count() && base.clip_of(f) == 0; ++f, ++frames) {
    Eigen::VectorXf reading = base.accelerations().col(f);
    for (float& value : reading) value += noise(rng);
    Eigen::Index k = 0;
    const Eigen::VectorXf& probabilities = filtered.Next(reading);
    EXPECT_NEAR(probabilities.sum(), 1, 1e-4);
    probabilities.maxCoeff(&k);
    right += k == clusters.of_frame[static_cast<std::size_t>(f)];
    nearest.Next(reading).maxCoeff(&k);
    nearest_right += k == clusters.of_frame[static_cast<std::size_t>(f)];
  }
  EXPECT_GT(right, nearest_right);
  EXPECT_GT(right, frames / 2);
}

TEST(RbfEstimator, FollowsAWalkThatItHasNotSeenSmoothlyAndWithoutDelay) {
  const MotionBase& base = SmallBase();
  const MotionClip walk = UnseenWalk();
  const Readings readings = VirtualAccelerations(walk, base.sensors(), 30);
  const auto quality_of = [&](const std::shared_ptr<const RbfModel>& model, int shift) {
    RbfEstimator estimator(model);
    std::vector<BasePose> poses;
    for (int f = 0; f < walk.frame_count(); ++f) poses.push_back(estimator.Next(readings.values.col(f)));
    poses.erase(poses.begin(), poses.begin() + 30);
    return CompareWithTruth(base, poses, walk.Slice(30 - shift, walk.frame_count() - 30));
  };
  const ReconstructionQuality with = quality_of(SmallModel(), 0);
  RbfOptions raw_options = SmallOptions();
  raw_options.window = 1;
  const ReconstructionQuality raw = quality_of(std::make_shared<const RbfModel>(base, raw_options), 0);
  EXPECT_LT(with.position_rms_cm, 3);
  EXPECT_LT(with.jerk_ratio, 1.3);
  EXPECT_LT(with.jerk_ratio, 0.6 * raw.jerk_ratio);
  EXPECT_LT(with.position_rms_cm, 1.02 * raw.position_rms_cm);
  // Late poses would be nearer to those of the frame before.
  EXPECT_LT(with.position_rms_cm, quality_of(SmallModel(), 1).position_rms_cm);
}

TEST(RbfEstimator, LearnsTheSameOnAnyNumberOfThreads) {
  const RbfModel& one = *SmallModel();
  RbfOptions options = SmallOptions();
  options.jobs = 2;
  const RbfModel two(SmallBase(), options);
  EXPECT_EQ(one.clusters.of_frame, two.clusters.of_frame);
  const Eigen::VectorXf reading = SmallBase().accelerations().col(50);
  EXPECT_EQ(one.maps[0].Value(reading), two.maps[0].Value(reading));
}

// A skeleton of few joints has fewer channels than the coordinates that are usual.
TEST(RbfEstimator, TakesNoMoreCoordinatesThanPosesHaveChannels) {
  RbfOptions options = SmallOptions();
  options.reduction.components = 1000;
  const RbfModel model(SmallBase(), options);
  EXPECT_EQ(model.reduction.components(), model.channels.Vectors(SmallBase()).rows());
  EXPECT_EQ(model.reduction.options().components, model.reduction.components());
}

TEST(RbfEstimator, SaysWhatIsWrong) {
  RbfEstimator estimator(SmallModel());
  try {
    estimator.Next(Eigen::VectorXd::Zero(9));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("9 values, not 12"));
  }
  RbfOptions options = SmallOptions();
  options.window = 0;
  EXPECT_THROW(RbfModel(SmallBase(), options), std::invalid_argument);
  EXPECT_THROW(RbfModel(MotionBase(testing::WalksOnOneSkeleton(2), {}, {}), SmallOptions()), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
