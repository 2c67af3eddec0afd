#include "synthesis/graph_walk.h"

#include <Eigen/Cholesky>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>

#include "graph/action_change.h"
#include "graph/walk_boundary.h"
#include "primitives/whitening.h"
#include "synthesis/draw_index.h"

namespace morphograph {
namespace {

constexpr double kLogTwoPi = 1.8378770664093454836;
constexpr int kOtherWalkers = 12;         // that are tried to go on from a start
constexpr double kSettingOff_m_s2 = 0.9;  // change of speed after a captured start: 0.74

Eigen::VectorXd DrawStandardNormal(int size, std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  Eigen::VectorXd values(size);
  for (double& value : values) value = normal(rng);
  return values;
}

// Noise of a transition: a residual of the capture that ended in the wanted component, drawn whole, so that what varies together in
// the capture varies together here. Gaussian where the capture has none.
Eigen::VectorXd DrawNoise(const TransitionModel& transition, int component, std::mt19937_64& rng) {
  std::vector<int> candidates;
  for (size_t i = 0; i < transition.residual_component.size(); ++i) {
    if (transition.residual_component[i] == component) candidates.push_back(static_cast<int>(i));
  }
  if (candidates.empty()) {
    return transition.noise_cholesky * DrawStandardNormal(static_cast<int>(transition.noise_cholesky.rows()), rng);
  }
  boost::random::uniform_int_distribution<int> pick(0, static_cast<int>(candidates.size()) - 1);
  return transition.residuals.col(candidates[pick(rng)]).cast<double>();
}

std::vector<double> RowOf(const Eigen::MatrixXd& matrix, int row) {
  std::vector<double> values(matrix.cols());
  for (Eigen::Index c = 0; c < matrix.cols(); ++c) values[c] = matrix(row, c);
  return values;
}

// w of what changes from step to step (see MannerModel), and the reverse.
Eigen::VectorXd InWalk(const MotionPrimitive& primitive, const Eigen::VectorXd& manner, const Eigen::VectorXd& within) {
  if (primitive.manner.empty()) return within;
  return manner + primitive.manner.WithinScale(within.size()).cwiseProduct(within);
}

Eigen::VectorXd WithinWalk(const MotionPrimitive& primitive, const Eigen::VectorXd& manner, const Eigen::VectorXd& whitened) {
  if (primitive.manner.empty()) return whitened;
  return (whitened - manner).cwiseQuotient(primitive.manner.WithinScale(whitened.size()));
}

// A mixture component by its chances, as the manner of the walk has it.
int DrawComponent(std::vector<double> chances, const Eigen::VectorXd& factors, std::mt19937_64& rng) {
  for (Eigen::Index c = 0; c < factors.size(); ++c) chances[static_cast<size_t>(c)] *= factors[c];
  return std::max(0, DrawIndex(chances, rng));
}

// Noise drawn whole can, once in thousands of steps, add up to a step far outside of everything captured.
void KeepInsideCapture(const MotionPrimitive& primitive, Eigen::VectorXd* whitened) {
  const double radius = whitened->norm();
  if (primitive.latent_radius > 0 && radius > primitive.latent_radius) *whitened *= primitive.latent_radius / radius;
}

// The step after `previous`, of its walker.
WalkStep DrawOn(const MotionGraph& graph, const WalkStep& previous, int edge, std::mt19937_64& rng) {
  const TransitionModel& transition = graph.transition(edge);
  WalkStep step;
  step.primitive = graph.edge_to(edge);
  step.edge = edge;
  const MotionPrimitive& model = graph.primitive(step.primitive);
  step.manner = previous.manner;
  DriftManner(graph, model.style_index, rng, &step.manner);
  step.component = DrawComponent(RowOf(transition.component_chances, previous.component), step.manner.components[step.primitive], rng);
  Eigen::VectorXd source = previous.whitened;
  if (previous.gathers_speed) KeepInsideCapture(graph.primitive(previous.primitive), &source);
  source = WithinWalk(graph.primitive(previous.primitive), previous.manner.m[previous.primitive], source);
  const Eigen::VectorXd mean = transition.Mean(source);
  step.gathers_speed = BeginsIn(graph.primitive(previous.primitive)) != WalkBoundary::kWalking;
  step.whitened = mean;
  // From gathering speed to a steady step that is drawn anywhere among them would be a leap: the most likely one leads over.
  if (!previous.gathers_speed) step.whitened += DrawNoise(transition, step.component, rng);
  step.whitened = InWalk(model, step.manner.m[step.primitive], step.whitened);
  if (!step.gathers_speed) KeepInsideCapture(model, &step.whitened);
  const MixtureComponent& component = model.mixture.Component(step.component);
  step.latent = Colour(component, step.whitened);

  const auto noise = transition.noise_cholesky.triangularView<Eigen::Lower>();
  const double log_volume = transition.noise_cholesky.diagonal().array().log().sum() +
                            model.manner.WithinScale(mean.size()).array().log().sum() + LogVolume(component);
  step.log_likelihood = std::log(transition.probability) +
                        std::log(transition.component_chances(previous.component, step.component)) -
                        0.5 * (noise.solve(WithinWalk(model, step.manner.m[step.primitive], step.whitened) - mean).squaredNorm() + mean.size() * kLogTwoPi) - log_volume;
  return step;
}

double SpeedChange_m_s2(const MotionGraph& graph, const WalkStep& step, const WalkStep& next) {
  return SpeedChange_m_s2(graph.primitive(step.primitive).Shape(step.latent), graph.primitive(next.primitive).Shape(next.latent));
}

}  // namespace

WalkStep DrawFirstStep(const MotionGraph& graph, int primitive, std::mt19937_64& rng) {
  const MotionPrimitive& model = graph.primitive(primitive);
  WalkStep step;
  step.primitive = primitive;
  std::vector<double> weights;
  for (int c = 0; c < model.mixture.size(); ++c) weights.push_back(std::exp(model.mixture.Component(c).log_weight));
  step.manner = DrawManner(graph, model.style_index, MetAt::kTime, rng);
  if (const Eigen::VectorXd& met = step.manner.met[static_cast<size_t>(primitive)]; met.size() > 0) weights.assign(met.begin(), met.end());
  step.component = std::max(0, DrawIndex(weights, rng));
  step.whitened = InWalk(model, step.manner.m[primitive], DrawStandardNormal(model.reduction.components(), rng));
  KeepInsideCapture(model, &step.whitened);
  step.latent = Colour(model.mixture.Component(step.component), step.whitened);
  step.log_likelihood = model.mixture.LogDensity(step.latent);
  return step;
}

WalkStep DrawNextStep(const MotionGraph& graph, const WalkStep& previous, int edge, std::mt19937_64& rng) {
  WalkStep step = DrawOn(graph, previous, edge, rng);
  if (!previous.gathers_speed || EndsIn(graph.primitive(step.primitive)) != WalkBoundary::kWalking) return step;
  // Who set off slowly goes on slowly: steps that gather speed are few and know nothing of the manner that was drawn with the first.
  double least = SpeedChange_m_s2(graph, previous, step);
  for (int i = 0; i < kOtherWalkers && least > kSettingOff_m_s2; ++i) {
    WalkStep other = previous;
    other.manner = DrawManner(graph, graph.primitive(previous.primitive).style_index, MetAt::kStep, rng);
    if (IsFree(previous.manner)) FreeComponents(&other.manner);
    WalkStep next = DrawOn(graph, other, edge, rng);
    const double change = SpeedChange_m_s2(graph, previous, next);
    if (change < least) least = change, step = std::move(next);
  }
  return step;
}

}  // namespace morphograph
