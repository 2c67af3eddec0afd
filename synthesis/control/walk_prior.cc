#include "synthesis/control/walk_prior.h"

#include <cmath>
#include <numbers>

#include "primitives/whitening.h"

namespace morphograph {

WithinWalk WithinWalkOf(const MotionGraph& graph, const WalkStep& step) {
  const MotionPrimitive& primitive = graph.primitive(step.primitive);
  const Eigen::Index size = primitive.reduction.components();
  WithinWalk within{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Ones(size)};
  if (!primitive.manner.empty()) within = {step.manner.m[static_cast<size_t>(step.primitive)], primitive.manner.WithinScale(size)};
  return within;
}

StepInnovation::StepInnovation(const MotionGraph& graph, const WalkStep& previous, const WalkStep& next)
    : transition_(graph.transition(next.edge)) {
  WithinWalk from = WithinWalkOf(graph, previous);
  const WithinWalk to = WithinWalkOf(graph, next);
  // The step after a start may be another walker's (DrawNextStep), who has made this one, too.
  const Eigen::VectorXd& of_next = next.manner.m[static_cast<size_t>(previous.primitive)];
  if (previous.gathers_speed && of_next.size() == from.manner.size()) from.manner = of_next;
  previous_manner_ = from.manner;
  previous_scale_ = from.scale;
  next_manner_ = to.manner;
  next_scale_ = to.scale;
  const auto noise = transition_.noise_cholesky.triangularView<Eigen::Lower>();
  by_next_ = next_scale_.cwiseInverse().asDiagonal();
  noise.solveInPlace(by_next_);
  linear_by_previous_ = -transition_.linear.cast<double>() * previous_scale_.cwiseInverse().asDiagonal();
  noise.solveInPlace(linear_by_previous_);
  const MixtureComponent& component = graph.primitive(next.primitive).mixture.Component(next.component);
  log_constant_ = std::log(transition_.probability) + std::log(transition_.component_chances(previous.component, next.component)) -
                  0.5 * dimension() * std::log(2 * std::numbers::pi) - transition_.noise_cholesky.diagonal().array().log().sum() -
                  next_scale_.array().log().sum() - LogVolume(component);
}

Eigen::VectorXd StepInnovation::Value(const Eigen::VectorXd& previous, const Eigen::VectorXd& next) const {
  const Eigen::VectorXd within = (next - next_manner_).cwiseQuotient(next_scale_);
  return transition_.noise_cholesky.triangularView<Eigen::Lower>().solve(within - transition_.Mean(Within(previous)));
}

Eigen::MatrixXd StepInnovation::ByPrevious(const Eigen::VectorXd& previous) const {
  if (!transition_.process) return linear_by_previous_;
  Eigen::MatrixXd rest = transition_.process->MeanJacobian(Within(previous)) * previous_scale_.cwiseInverse().asDiagonal();
  transition_.noise_cholesky.triangularView<Eigen::Lower>().solveInPlace(rest);
  return linear_by_previous_ - rest;
}

double StepInnovation::LogLikelihood(const Eigen::VectorXd& previous, const Eigen::VectorXd& next) const {
  return log_constant_ - 0.5 * Value(previous, next).squaredNorm();
}

void MoveTo(const MotionGraph& graph, const Eigen::VectorXd& whitened, WalkStep* step) {
  step->whitened = whitened;
  step->latent = Colour(graph.primitive(step->primitive).mixture.Component(step->component), whitened);
}

}  // namespace morphograph
