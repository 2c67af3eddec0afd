#include "synthesis/sensors/gaussian_estimator.h"

#include <gtest/gtest.h>

#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/support/random_matrix.h"
#include "tests/synthesis/small_base.h"

namespace morphograph {
namespace {

using testing::SmallBase;

GaussianOptions SmallGaussian() {
  GaussianOptions options;
  options.reduction.components = 12;
  options.clusters.max_clusters = 12;
  options.clusters.fit_frames = 500;
  return options;
}

std::shared_ptr<const GaussianModel> SmallGaussianModel() {
  static const auto model = std::make_shared<const GaussianModel>(SmallBase(), SmallGaussian());
  return model;
}

TEST(GaussianPoseCost, JacobianIsTheSlopeOfTheResiduals) {
  const GaussianModel& model = *SmallGaussianModel();
  std::mt19937_64 rng(4);
  const Eigen::VectorXf shares = Eigen::VectorXf::Constant(model.clusters.count(), 1.f / static_cast<float>(model.clusters.count()));
  const Eigen::VectorXf readings = 5 * testing::RandomNormal(12 * 4, 1, rng).cast<float>();
  const Eigen::VectorXd expected = 0.05 * testing::RandomNormal(12, 1, rng), at = 0.05 * testing::RandomNormal(12, 1, rng);
  const GaussianPoseCost cost(model, shares, readings, expected);
  ASSERT_EQ(cost.NumResiduals(), 12 + 12 + 48);
  Eigen::VectorXd residuals(72), ahead(72), behind(72);
  Eigen::MatrixXd jacobian(72, 12);
  cost(at.data(), residuals.data(), jacobian.data());
  cost(at.data(), ahead.data(), nullptr);
  EXPECT_TRUE(ahead.isApprox(residuals, 1e-5));
  for (int i = 0; i < 12; ++i) {
    const Eigen::VectorXd step = 2e-3 * Eigen::VectorXd::Unit(12, i), forward = at + step, backward = at - step;
    cost(forward.data(), ahead.data(), nullptr);
    cost(backward.data(), behind.data(), nullptr);
    // Single precision inside.
    EXPECT_LT(((ahead - behind) / 4e-3 - jacobian.col(i)).norm(), 0.02 * jacobian.col(i).norm() + 0.05) << i;
  }
}

TEST(GaussianEstimator, FollowsAWalkThatItHasNotSeen) {
  const MotionClip walk = testing::UnseenWalk();
  const Readings readings = VirtualAccelerations(walk, SmallBase().sensors(), 30);
  const auto quality_of = [&](const std::shared_ptr<const GaussianModel>& model) {
    GaussianEstimator estimator(model);
    std::vector<BasePose> poses;
    for (int f = 0; f < walk.frame_count(); ++f) poses.push_back(estimator.Next(readings.values.col(f)));
    poses.erase(poses.begin(), poses.begin() + 20);
    return CompareWithTruth(SmallBase(), poses, walk.Slice(20, walk.frame_count() - 20));
  };
  const ReconstructionQuality quality = quality_of(SmallGaussianModel());
  EXPECT_LT(quality.position_rms_cm, 3);
  EXPECT_LT(quality.jerk_ratio, 2);
  GaussianOptions options = SmallGaussian();
  options.smoothness_weight = 0;
  const auto jolting = std::make_shared<const GaussianModel>(SmallBase(), options);
  EXPECT_GT(quality_of(jolting).jerk_ratio, quality.jerk_ratio);
  options = SmallGaussian();
  options.control_weight = 0;
  EXPECT_GT(quality_of(std::make_shared<const GaussianModel>(SmallBase(), options)).position_rms_cm, quality.position_rms_cm);
}

// A body that is shaken more than those of the base: every reading would jolt the pose.
TEST(GaussianEstimator, TrustsReadingsLessThatItCannotExplain) {
  const MotionClip walk = testing::UnseenWalk();
  Eigen::MatrixXd readings = VirtualAccelerations(walk, SmallBase().sensors(), 30).values;
  const Eigen::VectorXd usual = readings.rowwise().mean();
  readings = (2.2 * (readings.colwise() - usual)).colwise() + usual;
  const auto quality_of = [&](const GaussianOptions& options) {
    GaussianEstimator estimator(std::make_shared<const GaussianModel>(SmallBase(), options));
    std::vector<BasePose> poses;
    for (int f = 0; f < walk.frame_count(); ++f) poses.push_back(estimator.Next(readings.col(f)));
    poses.erase(poses.begin(), poses.begin() + 20);
    return CompareWithTruth(SmallBase(), poses, walk.Slice(20, walk.frame_count() - 20));
  };
  GaussianOptions trusting = SmallGaussian();
  trusting.surprise_s = 0;
  const ReconstructionQuality jolted = quality_of(trusting), quality = quality_of(SmallGaussian());
  EXPECT_LT(quality.jerk_ratio, 0.8 * jolted.jerk_ratio);
  EXPECT_LT(quality.position_rms_cm, 1.05 * jolted.position_rms_cm);
}

// Readings that hardly change come from a body that hardly moves.
TEST(GaussianEstimator, JoltsSlowMotionLess) {
  const MotionClip walk = testing::UnseenWalk();
  Eigen::MatrixXd readings = VirtualAccelerations(walk, SmallBase().sensors(), 30).values;
  const Eigen::VectorXd usual = readings.rowwise().mean();
  readings = (0.3 * (readings.colwise() - usual)).colwise() + usual;
  const auto jerk_of = [&](const GaussianOptions& options) {
    GaussianEstimator estimator(std::make_shared<const GaussianModel>(SmallBase(), options));
    std::vector<BasePose> poses;
    for (int f = 0; f < walk.frame_count(); ++f) poses.push_back(estimator.Next(readings.col(f)));
    poses.erase(poses.begin(), poses.begin() + 20);
    return CompareWithTruth(SmallBase(), poses, walk.Slice(20, walk.frame_count() - 20)).jerk_ratio;
  };
  GaussianOptions even = SmallGaussian();
  even.activity_power = 0;
  const double jerk = jerk_of(SmallGaussian());
  EXPECT_LT(jerk, 0.9 * jerk_of(even));
  EXPECT_GT(jerk, 0.1 * jerk_of(even));  // a pose that is held still would be no answer
}

TEST(GaussianEstimator, SaysWhatIsWrong) {
  GaussianEstimator estimator(SmallGaussianModel());
  EXPECT_THROW(estimator.Next(Eigen::VectorXd::Zero(5)), std::invalid_argument);
  GaussianOptions options = SmallGaussian();
  options.reduction.kind = ReductionKind::kLle;
  EXPECT_THROW(GaussianModel(SmallBase(), options), std::invalid_argument);
  options = SmallGaussian();
  options.surprise_s = -1;
  EXPECT_THROW(GaussianModel(SmallBase(), options), std::invalid_argument);
  options = SmallGaussian();
  options.activity_power = -1;
  EXPECT_THROW(GaussianModel(SmallBase(), options), std::invalid_argument);
  options = SmallGaussian();
  options.control_stride = 0;
  EXPECT_THROW(GaussianModel(SmallBase(), options), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
