#include "synthesis/sensors/neighbourhood_energy.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/olng_setting.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

// Random targets of the sizes that the base asks for.
NeighbourhoodTargets RandomTargets(std::mt19937_64& rng) {
  const MotionBase& base = *testing::OlngShared().base;
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
    const NeighbourhoodEnergy energy(*testing::OlngShared().base, RandomTargets(rng), options);
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
  const MotionBase& base = *testing::OlngShared().base;
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
    const NeighbourhoodEnergy energy(*testing::OlngShared().base, RandomTargets(rng), options);
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

}  // namespace
}  // namespace morphograph
