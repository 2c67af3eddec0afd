#include "graph/manner_fit.h"

#include <gtest/gtest.h>

#include <boost/random/normal_distribution.hpp>
#include <random>

namespace morphograph {
namespace {

// Walks of `length` steps whose first value keeps a share of 0.6 over the walk; the second value keeps nothing, but follows its
// neighbour at 0.7, as a turn does.
MannerSteps Walks(int walks, int length, std::vector<double>* manners) {
  std::mt19937_64 rng(4);
  boost::random::normal_distribution<double> normal;
  MannerSteps steps;
  steps.walks = walks;
  steps.component_weights = Eigen::Vector2d(0.5, 0.5);
  steps.whitened.resize(2, walks * length);
  for (int walk = 0; walk < walks; ++walk) {
    const double manner = std::sqrt(0.6) * normal(rng);
    manners->push_back(manner);
    double turn = normal(rng);
    for (int i = 0; i < length; ++i) {
      const int column = walk * length + i;
      steps.whitened(0, column) = manner + std::sqrt(0.4) * normal(rng);
      steps.whitened(1, column) = turn;
      turn = 0.5 * turn + std::sqrt(1 - 0.25) * normal(rng);
      steps.component.push_back(walk % 2);
      steps.walk.push_back(walk);
      steps.ordinal.push_back(2 * i);
      steps.seconds.push_back(0.5);
    }
  }
  return steps;
}

TEST(MannerFit, FindsWhatStaysOverAWalkAndOnlyThat) {
  std::vector<double> truth;
  const MannerModel manner = FitManner(Walks(300, 6, &truth));
  ASSERT_FALSE(manner.empty());
  EXPECT_NEAR(manner.share[0], 0.6, 0.08);
  // Steps four apart, two of these here, share a quarter of a turn: some of it is taken for a manner.
  EXPECT_LT(manner.share[1], 0.2);
  double missed = 0, all = 0;
  for (size_t walk = 0; walk < truth.size(); ++walk) {
    missed += std::pow(manner.captured(0, static_cast<Eigen::Index>(walk)) - truth[walk], 2);
    all += truth[walk] * truth[walk];
  }
  // Of the best prediction from six steps, 0.4 / 6 / (0.6 + 0.4 / 6) = 0.1 of the variance is missed.
  EXPECT_NEAR(missed / all, 0.1, 0.03);
  // Six steps of one component and a hundredth of a step of all walks, against a half.
  EXPECT_NEAR(manner.met(0, 0), 6.005 / 6.01, 1e-5);
  EXPECT_NEAR(manner.met(1, 0), 0.005 / 6.01, 1e-5);
  EXPECT_NEAR(manner.components(0, 0), 6.005 / 6.01 / 0.5, 1e-5);
  EXPECT_NEAR(manner.components(1, 0), 0.005 / 6.01 / 0.5, 1e-5);
}

TEST(MannerFit, FindsNoneInStepsThatShareNothing) {
  std::mt19937_64 rng(9);
  boost::random::normal_distribution<double> normal;
  MannerSteps steps;
  steps.walks = 100;
  steps.component_weights = Eigen::VectorXd::Ones(1);
  steps.whitened.resize(30, 600);
  for (double& value : steps.whitened.reshaped()) value = normal(rng);
  for (int i = 0; i < 600; ++i) {
    steps.component.push_back(0);
    steps.walk.push_back(i / 6);
    steps.ordinal.push_back(i % 6);
    steps.seconds.push_back(0.5);
  }
  const MannerModel manner = FitManner(steps);
  ASSERT_FALSE(manner.empty());
  EXPECT_LE((manner.share.array() > 0).count(), 4);  // at twice the standard error one in forty passes
  EXPECT_LT(manner.share.maxCoeff(), 0.25);
}

TEST(MannerFit, NeedsWalksOfSeveralSteps) {
  MannerSteps steps;
  steps.walks = 50;
  steps.component_weights = Eigen::VectorXd::Ones(1);
  steps.whitened = Eigen::MatrixXd::Ones(3, 50);
  for (int i = 0; i < 50; ++i) steps.component.push_back(0), steps.walk.push_back(i), steps.ordinal.push_back(0), steps.seconds.push_back(1);
  EXPECT_TRUE(FitManner(steps).empty());
  steps.walk.pop_back();
  EXPECT_THROW(FitManner(steps), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
