#include "synthesis/control/residuals/swing_residual.h"

namespace morphograph {
namespace {

constexpr double kSwingFirmness = 0.25;  // of a quantity's deviation among steps: how far beyond its range it is likely to be moved

}  // namespace

SwingResidual::SwingResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> ball, const SwingRange& range)
    : StepResidual(std::move(step), 2 * kSwingSpans), ball_(std::move(ball)), range_(range) {}

StepResidual::Linear SwingResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace&) const {
  const SwingState swing = SwingOf(step(), *ball_, w);
  Linear linear{Eigen::VectorXd::Zero(2 * kSwingSpans), Eigen::MatrixXd::Zero(2 * kSwingSpans, w.size()), Eigen::MatrixXd::Zero(2 * kSwingSpans, 4)};
  const auto add = [&](Eigen::Index row, double beyond, const Eigen::RowVectorXd& by_latent, double deviation) {
    if (beyond <= 0) return;
    linear.value[row] = beyond / (kSwingFirmness * deviation);
    linear.by_latent.row(row) = by_latent / (kSwingFirmness * deviation);
  };
  for (Eigen::Index i = 0; i < kSwingSpans; ++i) {
    add(i, swing.speed_m_s[i] - range_.speed_m_s, swing.speed_by_latent.row(i), range_.speed_deviation_m_s);
    add(kSwingSpans + i, swing.height_m[i] - range_.height_m, swing.height_by_latent.row(i), range_.height_deviation_m);
  }
  return linear;
}

}  // namespace morphograph
