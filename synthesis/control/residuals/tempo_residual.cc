#include "synthesis/control/residuals/tempo_residual.h"

#include <cmath>

namespace morphograph {
namespace {

constexpr double kUsualTempo = 2.576;   // normal deviations that 99 of 100 lie within
constexpr double kTempoFirmness = 0.25;  // in them: how far beyond a slope is likely to be moved

}  // namespace

TempoResidual::TempoResidual(std::shared_ptr<const StepKinematics> step) : StepResidual(std::move(step), kWarpKnots) {}

StepResidual::Linear TempoResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace&) const {
  const Eigen::MatrixXd by_latent = step().model().timing().by_latent.bottomRows<kWarpKnots>();
  Linear linear{Eigen::VectorXd::Zero(kWarpKnots), Eigen::MatrixXd::Zero(kWarpKnots, w.size()), Eigen::MatrixXd::Zero(kWarpKnots, 4)};
  for (Eigen::Index k = 0; k < kWarpKnots; ++k) {
    // The latent is N(0, I): a slope lies so many deviations from its mean.
    const double deviation = by_latent.row(k).norm();
    const double off = deviation > 0 ? by_latent.row(k).dot(w) / deviation : 0;
    if (std::abs(off) <= kUsualTempo) continue;
    linear.value[k] = (off - std::copysign(kUsualTempo, off)) / kTempoFirmness;
    linear.by_latent.row(k) = by_latent.row(k) / (deviation * kTempoFirmness);
  }
  return linear;
}

}  // namespace morphograph
