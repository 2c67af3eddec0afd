#include "synthesis/walk_manner.h"

#include <gtest/gtest.h>

#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "synthesis/graph_walk.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

constexpr int kWalksOfAComponent = 30, kStepsOfAWalk = 6;
constexpr double kShare = 0.5, kMeanOfA = 1, kSpread = 0.5;

// Two primitives of one latent value each. Thirty captured walks keep to mixture component A and have manners about 1, thirty keep to B and
// have manners about -1; a walk's manner in the second primitive is the negative of that in the first.
GraphContents TwoKindsOfWalks() {
  std::mt19937_64 rng(3);
  boost::random::normal_distribution<double> normal;
  MannerModel manner;
  manner.share = Eigen::VectorXd::Constant(1, kShare);
  manner.steps.assign(2 * kWalksOfAComponent, kStepsOfAWalk);
  manner.seconds.assign(2 * kWalksOfAComponent, 3);
  manner.captured.resize(1, 2 * kWalksOfAComponent);
  manner.components.resize(2, 2 * kWalksOfAComponent);
  manner.met.resize(2, 2 * kWalksOfAComponent);
  Eigen::VectorXd around(kWalksOfAComponent);
  for (double& value : around) value = normal(rng);
  around.array() -= around.mean();
  around *= kSpread / std::sqrt(around.squaredNorm() / kWalksOfAComponent);
  for (int i = 0; i < kWalksOfAComponent; ++i) {
    manner.captured(0, i) = static_cast<float>(kMeanOfA + around[i]);
    manner.captured(0, kWalksOfAComponent + i) = static_cast<float>(-kMeanOfA + around[i]);
    manner.components.col(i) = Eigen::Vector2f(1.99f, 0.01f);
    manner.components.col(kWalksOfAComponent + i) = Eigen::Vector2f(0.01f, 1.99f);
    manner.met.col(i) = Eigen::Vector2f(0.995f, 0.005f);
    manner.met.col(kWalksOfAComponent + i) = Eigen::Vector2f(0.005f, 0.995f);
  }
  const auto model = testing::SmallModel();
  GraphContents contents;
  contents.layout = model->layout();
  contents.styles = {model->styles().front()};
  MotionPrimitive primitive;
  primitive.name = "left";
  primitive.reduction.mean = model->primitive(0).reduction.mean;
  primitive.reduction.basis = model->primitive(0).reduction.basis.leftCols(1);
  const MixtureComponent component{std::log(0.5), Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1)};
  primitive.mixture = GaussianMixture({component, component});
  primitive.manner = manner;
  contents.primitives.push_back(primitive);
  primitive.name = "right";
  primitive.manner.captured *= -1;
  contents.primitives.push_back(primitive);
  return contents;
}

struct Moments {
  int count = 0;
  double sum = 0, squares = 0;
  void Add(double value) { ++count, sum += value, squares += value * value; }
  double mean() const { return sum / count; }
  double variance() const { return squares / count - mean() * mean(); }
};

TEST(WalkManner, DriftKeepsMeanAndVarianceOfEachMixtureComponent) {
  const MotionGraph graph(TwoKindsOfWalks(), "");
  // Of walks in a component: what differs between the captured ones, and what six steps do not tell of one.
  const double variance = kSpread * kSpread + kShare * (1 - kShare) / (kStepsOfAWalk * kShare + 1 - kShare);
  Moments first[2], last[2];
  double together = 0, kept_products = 0, least_factor = 2;
  std::mt19937_64 rng(8);
  constexpr int kWalks = 1500, kDriftSteps = 46;
  for (int walk = 0; walk < kWalks; ++walk) {
    WalkManner manner = DrawManner(graph, 0, MetAt::kStep, rng);
    const int own = manner.components[0][0] > manner.components[0][1] ? 0 : 1;
    const double sign = own == 0 ? 1 : -1, before = manner.m[0][0];
    first[own].Add(before);
    for (int step = 0; step < kDriftSteps; ++step) DriftManner(graph, 0, rng, &manner);
    last[own].Add(manner.m[0][0]);
    kept_products += (before - sign * kMeanOfA) * (manner.m[0][0] - sign * kMeanOfA) / variance / kWalks;
    together -= (manner.m[0][0] - sign * kMeanOfA) * (manner.m[1][0] + sign * kMeanOfA) / variance / kWalks;
    least_factor = std::min(least_factor, manner.components[0][own]);
  }
  for (int own = 0; own < 2; ++own) {
    const double sign = own == 0 ? 1 : -1;
    EXPECT_GT(first[own].count, kWalks * 0.45);
    EXPECT_NEAR(first[own].mean(), sign * kMeanOfA, 0.08);  // four standard errors; a walk of the other component now and then
    EXPECT_NEAR(last[own].mean(), sign * kMeanOfA, 0.12);
    EXPECT_NEAR(first[own].variance() / variance, 1, 0.2);
    EXPECT_NEAR(last[own].variance() / variance, 1, 0.25);
  }
  EXPECT_NEAR(kept_products, 0.5, 0.12);  // half of a manner is left after 46 steps
  // What goes together in a captured walk, its noise apart, goes together after any number of steps.
  EXPECT_NEAR(together, kSpread * kSpread / variance, 0.15);
  EXPECT_GT(least_factor, 1);  // no walk has gone over to the other component
}

// The factors are what a walk needs to keep meeting components as often; a first step follows none.
TEST(WalkManner, FirstStepsMeetComponentsAsOftenAsCapturedOnes) {
  GraphContents contents = TwoKindsOfWalks();
  for (MotionPrimitive& primitive : contents.primitives) {
    primitive.manner.met.row(0).setConstant(0.9f);
    primitive.manner.met.row(1).setConstant(0.1f);
    primitive.manner.components.setOnes();
  }
  const MotionGraph graph(std::move(contents), "");
  std::mt19937_64 rng(5);
  int of_first = 0;
  for (int i = 0; i < 2000; ++i) of_first += DrawFirstStep(graph, 0, rng).component == 0;
  EXPECT_NEAR(of_first / 2000.0, 0.9, 0.03);
}

TEST(WalkManner, IsMetAsOftenAsItTakesStepsOrTime) {
  GraphContents contents = TwoKindsOfWalks();
  for (MotionPrimitive& primitive : contents.primitives) {  // walks of B are three times as slow
    std::fill(primitive.manner.seconds.begin() + kWalksOfAComponent, primitive.manner.seconds.end(), 9.0f);
  }
  const MotionGraph graph(std::move(contents), "");
  std::mt19937_64 rng(5);
  int of_b[2] = {0, 0};
  for (int i = 0; i < 2000; ++i) {
    of_b[0] += DrawManner(graph, 0, MetAt::kStep, rng).components[0][1] > 1;
    of_b[1] += DrawManner(graph, 0, MetAt::kTime, rng).components[0][1] > 1;
  }
  EXPECT_NEAR(of_b[0] / 2000.0, 0.5, 0.04);
  EXPECT_NEAR(of_b[1] / 2000.0, 0.75, 0.04);
}

// Where a way bends, a walk may need steps that its manner never takes.
TEST(WalkManner, FreedMeetsAllComponentsAndKeepsItsManner) {
  const MotionGraph graph(TwoKindsOfWalks(), "");
  std::mt19937_64 rng(5);
  WalkManner manner = DrawManner(graph, 0, MetAt::kStep, rng);
  const double before = manner.m[0][0];
  FreeComponents(&manner);
  EXPECT_EQ(manner.components[0].size(), 0);
  EXPECT_EQ(manner.met[0].size(), 0);
  EXPECT_EQ(manner.m[0][0], before);
  for (int step = 0; step < 500; ++step) DriftManner(graph, 0, rng, &manner);
  EXPECT_EQ(manner.components[0].size(), 0);
  EXPECT_EQ(manner.components[1].size(), 0);
  EXPECT_TRUE(manner.m[0].allFinite());
}

// Walks that are like many others must not be met ever more often, and none may become a mean of several.
TEST(WalkManner, LongWalksKeepToComponentsOfCapturedOnesByTheirSteps) {
  GraphContents contents = TwoKindsOfWalks();
  for (MotionPrimitive& primitive : contents.primitives) {  // a third of the walks of A keep to both components
    for (int i = 0; i < kWalksOfAComponent / 3; ++i) {
      primitive.manner.components.col(i) = Eigen::Vector2f(1, 1);
      primitive.manner.met.col(i) = Eigen::Vector2f(0.5f, 0.5f);
    }
  }
  const MotionGraph graph(std::move(contents), "");
  std::mt19937_64 rng(9);
  Moments of_a, both;
  for (int walk = 0; walk < 250; ++walk) {
    WalkManner manner = DrawManner(graph, 0, MetAt::kStep, rng);
    for (int step = 0; step < 3000; ++step) {
      DriftManner(graph, 0, rng, &manner);
      const double factor = manner.components[0][0];
      ASSERT_TRUE(std::abs(factor - 1.99) < 1e-6 || std::abs(factor - 0.01) < 1e-6 || factor == 1) << factor;
      of_a.Add(factor > 1.5), both.Add(factor == 1);
    }
  }
  // Without the weighing of proposals, 0.25 and less of A.
  EXPECT_NEAR(both.mean(), 1.0 / 6, 0.02);
  EXPECT_NEAR(of_a.mean(), 1.0 / 3, 0.04);
}

TEST(WalkManner, IsEmptyWithoutModels) {
  GraphContents contents = TwoKindsOfWalks();
  for (MotionPrimitive& primitive : contents.primitives) primitive.manner = {};
  const MotionGraph graph(std::move(contents), "");
  std::mt19937_64 rng(5);
  WalkManner manner = DrawManner(graph, 0, MetAt::kTime, rng);
  DriftManner(graph, 0, rng, &manner);
  ASSERT_EQ(manner.m.size(), 2u);
  EXPECT_EQ(manner.m[0].size(), 0);
  EXPECT_EQ(manner.components[1].size(), 0);
}

}  // namespace
}  // namespace morphograph
