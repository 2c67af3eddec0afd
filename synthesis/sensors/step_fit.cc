#include "synthesis/sensors/step_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "primitives/cubic_resample.h"

namespace morphograph {
namespace {

// Weight of the log of a step's duration among its readings, in m/s^2 a unit and sample.
constexpr double kDurationWeight = 10;
constexpr std::size_t kStyleVotes = 32;

// argmin |x|^2 + |W (L x - d)|^2 / sigma^2 for diagonal W, for one L and several W: the larger of the two possible products is never made, the smaller one once.
class LatentSolver {
 public:
  explicit LatentSolver(const Eigen::MatrixXd& local) : local_(local), by_rows_(local.cols() > local.rows()) {
    if (by_rows_) products_ = Products(local.cast<float>());
  }
  Eigen::VectorXd Solve(const Eigen::VectorXd& weights, const Eigen::VectorXd& wanted, double sigma) const {
    // (L^T W^2 L + sigma^2) x = L^T W^2 d, or x = L^T W (W L L^T W + sigma^2)^-1 W d.
    if (by_rows_) {
      Eigen::MatrixXd normal = weights.asDiagonal() * products_ * weights.asDiagonal();
      normal.diagonal().array() += sigma * sigma;
      const Eigen::LLT<Eigen::MatrixXd> solver(normal);
      return local_.transpose() * weights.cwiseProduct(solver.solve(weights.cwiseProduct(wanted)));
    }
    const Eigen::MatrixXd weighted = weights.asDiagonal() * local_;
    Eigen::MatrixXd normal = Products(weighted.transpose().cast<float>());
    normal.diagonal().array() += sigma * sigma;
    const Eigen::LLT<Eigen::MatrixXd> solver(normal);
    return solver.solve(weighted.transpose() * weights.cwiseProduct(wanted));
  }

 private:
  // A A^T. In single precision, half the time: what it loses is far below sigma^2.
  static Eigen::MatrixXd Products(const Eigen::MatrixXf& a) {
    Eigen::MatrixXf lower = Eigen::MatrixXf::Zero(a.rows(), a.rows());
    lower.selfadjointView<Eigen::Lower>().rankUpdate(a);
    return Eigen::MatrixXf(lower.selfadjointView<Eigen::Lower>()).cast<double>();
  }

  const Eigen::MatrixXd& local_;
  bool by_rows_;
  Eigen::MatrixXd products_;
};

}  // namespace

FittedStep FitStep(const CapturedSteps& steps, const Eigen::MatrixXd& readings, const FoundStep& found, const StepFitOptions& options) {
  const StepBank& bank = steps.landing(found.left);
  const Eigen::Index sensors = readings.rows();
  Eigen::VectorXd positions(kPhaseSamples);
  int first = kPhaseSamples, last = -1;
  for (int i = 0; i < kPhaseSamples; ++i) {
    positions[i] = found.start_frame + PhaseOfSample(i) * found.frames();
    if (positions[i] >= 0 && positions[i] <= static_cast<double>(readings.cols() - 1)) first = std::min(first, i), last = i;
  }
  const int samples = std::max(0, last - first + 1);
  const Eigen::Index rows = samples * sensors;
  const double duration_weight = kDurationWeight * std::sqrt(static_cast<double>(std::max<Eigen::Index>(rows, 1)));
  const double log_duration = std::log(found.frames() / kSensorRate_hz);
  Eigen::VectorXd wanted(rows + 1);
  if (samples > 0) wanted.head(rows) = ResampleCubic(readings, positions.segment(first, samples)).reshaped();
  wanted[rows] = duration_weight * log_duration;
  const auto captured = [&](Eigen::Index step) {
    Eigen::VectorXd values(rows + 1);
    values << bank.readings.col(step).segment(first % kPhaseSamples * sensors, rows).cast<double>(), duration_weight * bank.log_durations[step];
    return values;
  };

  Eigen::VectorXf distances = (bank.readings.middleRows(first % kPhaseSamples * sensors, rows).colwise() - wanted.head(rows).cast<float>()).colwise().squaredNorm();
  distances.array() += (static_cast<float>(duration_weight) * (bank.log_durations.array() - static_cast<float>(log_duration))).square();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(bank.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const std::size_t count = std::min(order.size(), static_cast<std::size_t>(std::max(1, options.neighbours)));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](Eigen::Index a, Eigen::Index b) { return distances[a] != distances[b] ? distances[a] < distances[b] : a < b; });

  FittedStep fitted;
  fitted.styles = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(steps.styles().size()));
  const std::size_t votes = std::min(count, kStyleVotes);
  for (std::size_t i = 0; i < votes; ++i) fitted.styles[bank.styles[static_cast<std::size_t>(order[i])]] += 1.0 / static_cast<double>(votes);

  const Eigen::Index n = static_cast<Eigen::Index>(count);
  Eigen::MatrixXd local(rows + 1, n);
  for (Eigen::Index i = 0; i < n; ++i) local.col(i) = captured(order[static_cast<std::size_t>(i)]);
  const Eigen::VectorXd mean = local.rowwise().mean();
  local.colwise() -= mean;
  local /= std::sqrt(static_cast<double>(n));
  const LatentSolver solver(local);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(rows + 1);
  Eigen::VectorXd latents = solver.Solve(weights, wanted - mean, options.sigma_m_s2);
  Eigen::VectorXd off = wanted - mean - local * latents;
  if (rows > 0) {
    // Sensors that captured steps do not explain to sigma deviate by as much as they are off: motion unlike any captured, or a sensor that sits askew.
    for (Eigen::Index sensor = 0; sensor < sensors; sensor += 3) {
      double squares = 0;
      for (int i = 0; i < samples; ++i) squares += off.segment<3>(i * sensors + sensor).squaredNorm();
      const double deviation = std::sqrt(squares / (3 * samples));
      if (deviation <= options.sigma_m_s2) continue;
      for (int i = 0; i < samples; ++i) weights.segment<3>(i * sensors + sensor).setConstant(options.sigma_m_s2 / deviation);
    }
    if (weights.minCoeff() < 1) {
      latents = solver.Solve(weights, wanted - mean, options.sigma_m_s2);
      off = wanted - mean - local * latents;
    }
    fitted.residual_m_s2 = std::sqrt(off.head(rows).squaredNorm() / static_cast<double>(rows));
  }
  // mean + P latents, P the centred poses over sqrt(n): weights of the captured steps that sum to 1.
  const Eigen::VectorXd shares = ((latents.array() - latents.mean()) / std::sqrt(static_cast<double>(n)) + 1.0 / static_cast<double>(n)).matrix();
  Eigen::VectorXd poses = Eigen::VectorXd::Zero(bank.poses.rows());
  for (Eigen::Index i = 0; i < n; ++i) poses += shares[i] * bank.poses.col(order[static_cast<std::size_t>(i)]).cast<double>();
  fitted.poses = poses.reshaped(steps.layout().channels(), kPhaseSamples);
  return fitted;
}

}  // namespace morphograph
