#include "synthesis/control/step_model.h"

#include "primitives/cubic_resample.h"

namespace morphograph {
namespace {

constexpr Eigen::Index kRootChannels = 6;

const UniformCubicSpline& Spline() {
  static const UniformCubicSpline spline(kPhaseSamples);
  return spline;
}

Eigen::VectorXd PositionOf(double phase) { return Eigen::VectorXd::Constant(1, (phase + kPhaseMargin) / kPhaseSpacing); }

// Weighted sum over the samples of a map whose rows go sample by sample.
StepModel::Map Sum(const StepModel::Map& samples, const Eigen::VectorXd& weights) {
  const Eigen::Index rows = samples.offset.size() / weights.size();
  StepModel::Map sum{Eigen::VectorXd::Zero(rows), Eigen::MatrixXd::Zero(rows, samples.by_latent.cols())};
  for (Eigen::Index s = 0; s < weights.size(); ++s) {
    if (weights[s] == 0) continue;
    sum.offset += weights[s] * samples.offset.segment(s * rows, rows);
    sum.by_latent += weights[s] * samples.by_latent.middleRows(s * rows, rows);
  }
  return sum;
}

}  // namespace

StepModel::StepModel(const MotionPrimitive& primitive, int component)
    : primitive_(primitive),
      component_(primitive.mixture.Component(component)),
      channels_((primitive.reduction.mean.size() - kTimingValues) / kPhaseSamples) {
  timing_ = Rows(channels_ * kPhaseSamples, kTimingValues);
  root_.offset.resize(kRootChannels * kPhaseSamples);
  Eigen::MatrixXd basis(kRootChannels * kPhaseSamples, primitive.reduction.components());
  for (Eigen::Index s = 0; s < kPhaseSamples; ++s) {
    root_.offset.segment<kRootChannels>(s * kRootChannels) = primitive.reduction.mean.segment<kRootChannels>(s * channels_);
    basis.middleRows<kRootChannels>(s * kRootChannels) = primitive.reduction.basis.middleRows<kRootChannels>(s * channels_).cast<double>();
  }
  root_.offset += basis * component_.mean;
  root_.by_latent = basis * component_.cholesky.triangularView<Eigen::Lower>();
}

StepModel::Map StepModel::Rows(Eigen::Index first, Eigen::Index count) const {
  const Eigen::MatrixXd basis = primitive_.reduction.basis.middleRows(first, count).cast<double>();
  return {primitive_.reduction.mean.segment(first, count) + basis * component_.mean, basis * component_.cholesky.triangularView<Eigen::Lower>()};
}

StepModel::Map StepModel::Root(double phase) const { return Sum(root_, Spline().Weights(PositionOf(phase))); }

StepModel::Map StepModel::RootRate(double phase) const {
  return Sum(root_, Spline().DerivativeWeights(PositionOf(phase)) / kPhaseSpacing);
}

StepModel::Map StepModel::Pose(double phase) const {
  if (!full_) full_ = Rows(0, channels_ * kPhaseSamples);
  return Sum(*full_, Spline().Weights(PositionOf(phase)));
}

const StepModel::Map& StepModel::KeptPose(double phase) const {
  const auto known = kept_.find(phase);
  return known != kept_.end() ? known->second : kept_.emplace(phase, Pose(phase)).first->second;
}

StepModel::Map StepModel::PoseRate(double phase) const {
  if (!full_) full_ = Rows(0, channels_ * kPhaseSamples);
  return Sum(*full_, Spline().DerivativeWeights(PositionOf(phase)) / kPhaseSpacing);
}

}  // namespace morphograph
