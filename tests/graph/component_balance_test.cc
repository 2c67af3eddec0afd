#include "graph/component_balance.h"

#include <gtest/gtest.h>

#include <boost/random/discrete_distribution.hpp>
#include <cmath>
#include <random>

namespace morphograph {
namespace {

constexpr double kTurning = 0.3;  // weight of the second component: steps that turn

// Steady steps of one value, straight ones and turns. Two walks: one that hardly turns, one that turns half of the time.
FittedPrimitive Steps(KeyframeLabel start, KeyframeLabel end) {
  FittedPrimitive fitted;
  MotionPrimitive& primitive = fitted.primitive;
  primitive.start = start;
  primitive.end = end;
  const MixtureComponent straight{std::log(1 - kTurning), Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1)};
  const MixtureComponent turning{std::log(kTurning), Eigen::VectorXd::Zero(1), 5 * Eigen::MatrixXd::Identity(1, 1)};
  primitive.mixture = GaussianMixture({straight, turning});
  primitive.manner.share = Eigen::VectorXd::Constant(1, 0.5);
  primitive.manner.captured = Eigen::MatrixXf::Zero(1, 2);
  primitive.manner.steps = {50, 50};
  // 10 % and 50 % of turns: together 30 %.
  primitive.manner.met.resize(2, 2);
  primitive.manner.met << 0.9f, 0.5f, 0.1f, 0.5f;
  primitive.manner.components.resize(2, 2);
  primitive.manner.components << 0.9f / 0.7f, 0.5f / 0.7f, 0.1f / 0.3f, 0.5f / 0.3f;
  return fitted;
}

GraphEdge Edge(int from, int to) {
  GraphEdge edge{from, to, {}};
  edge.model.probability = 1;
  edge.model.component_chances.resize(2, 2);
  edge.model.component_chances << 0.9, 0.1, 0.25, 0.75;  // a turn takes more than a step
  return edge;
}

// Part of turns in long walks of the manners of these captured ones, by drawing them.
double Turns(const std::vector<FittedPrimitive>& fitted, const std::vector<GraphEdge>& edges, const std::vector<int>& walks = {0, 1}) {
  std::mt19937_64 rng(5);
  double turns = 0, steps = 0;
  for (const int walk : walks) {
    const MannerModel& manner = fitted[0].primitive.manner;
    int at = 0, component = 0;
    for (int step = 0; step < 100000; ++step) {
      const Eigen::MatrixXd& chances = edges[static_cast<size_t>(at)].model.component_chances;
      const double p[] = {chances(component, 0) * static_cast<double>(manner.components(0, walk)),
                          chances(component, 1) * static_cast<double>(manner.components(1, walk))};
      component = boost::random::discrete_distribution<int>(p, p + 2)(rng);
      at = 1 - at;
      turns += manner.steps[static_cast<size_t>(walk)] * component;
      steps += manner.steps[static_cast<size_t>(walk)];
    }
  }
  return turns / steps;
}

TEST(ComponentBalance, WalksTurnAsOftenAsCapturedOnes) {
  std::vector<FittedPrimitive> fitted = {Steps(KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance),
                                         Steps(KeyframeLabel::kRightStance, KeyframeLabel::kLeftStance)};
  std::vector<GraphEdge> edges = {Edge(0, 1), Edge(1, 0)};
  ASSERT_GT(std::abs(Turns(fitted, edges) - kTurning), 0.02);
  BalanceComponents(&fitted, &edges);
  EXPECT_NEAR(Turns(fitted, edges), kTurning, 0.005);
  EXPECT_NEAR(Turns(fitted, edges, {0}), 0.1, 0.005) << "each as often as itself";
  EXPECT_NEAR(Turns(fitted, edges, {1}), 0.5, 0.005);
  for (const GraphEdge& edge : edges) {
    EXPECT_NEAR(edge.model.component_chances.row(0).sum(), 1, 1e-12);
    EXPECT_NEAR(edge.model.component_chances.row(1).sum(), 1, 1e-12);
    // Turns still follow turns.
    EXPECT_GT(edge.model.component_chances(1, 1), 3 * edge.model.component_chances(0, 1));
  }
}

// A clip that holds a step of one foot alone says nothing of the other's.
TEST(ComponentBalance, AsksNothingOfStepsThatAWalkHasNot) {
  std::vector<FittedPrimitive> fitted = {Steps(KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance),
                                         Steps(KeyframeLabel::kRightStance, KeyframeLabel::kLeftStance)};
  MannerModel& right = fitted[1].primitive.manner;
  right.steps[0] = 0;
  right.met.col(0) << 0.7f, 0.3f;
  right.components.col(0).setOnes();
  std::vector<GraphEdge> edges = {Edge(0, 1), Edge(1, 0)};
  BalanceComponents(&fitted, &edges);
  EXPECT_EQ(right.components.col(0), Eigen::Vector2f(1, 1));
}

TEST(ComponentBalance, StepsIntoAWalkKeepTheirChances) {
  FittedPrimitive start = Steps(KeyframeLabel::kStanding, KeyframeLabel::kRightStance);
  std::vector<FittedPrimitive> fitted = {Steps(KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance),
                                         Steps(KeyframeLabel::kRightStance, KeyframeLabel::kLeftStance), start};
  std::vector<GraphEdge> edges = {Edge(0, 1), Edge(1, 0), Edge(2, 1)};
  const Eigen::MatrixXd before = edges[2].model.component_chances;
  BalanceComponents(&fitted, &edges);
  EXPECT_EQ(edges[2].model.component_chances, before);
}

}  // namespace
}  // namespace morphograph
