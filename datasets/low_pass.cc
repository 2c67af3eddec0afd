#include "datasets/low_pass.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace morphograph {
namespace {

// Second-order Butterworth section by the bilinear transform, cutoff pre-warped.
struct Biquad {
  double b0, b1, b2, a1, a2;

  explicit Biquad(double cutoff_over_rate) {
    const double k = std::tan(std::numbers::pi * cutoff_over_rate);
    const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
    b0 = k * k * norm;
    b1 = 2 * b0;
    b2 = b0;
    a1 = 2 * (k * k - 1) * norm;
    a2 = (1 - std::numbers::sqrt2 * k + k * k) * norm;
  }

  // Transposed direct form II over columns, its state started as if the first column had stood for ever.
  void Run(Eigen::MatrixXd* samples) const {
    const Eigen::VectorXd first = samples->col(0);
    Eigen::VectorXd s1 = first * (1 - b0);
    Eigen::VectorXd s2 = first * (b2 - a2);
    for (Eigen::Index c = 0; c < samples->cols(); ++c) {
      const Eigen::VectorXd in = samples->col(c);
      const Eigen::VectorXd out = b0 * in + s1;
      s1 = b1 * in - a1 * out + s2;
      s2 = b2 * in - a2 * out;
      samples->col(c) = out;
    }
  }
};

}  // namespace

Eigen::MatrixXd LowPass(const Eigen::MatrixXd& samples, double frame_rate_hz, double cutoff_hz) {
  if (!(frame_rate_hz > 0) || !(cutoff_hz > 0)) {
    throw std::invalid_argument("LowPass: frame rate and cutoff must be positive");
  }
  const Eigen::Index frames = samples.cols();
  if (frames < 2 || cutoff_hz >= 0.5 * frame_rate_hz) return samples;
  // The filter forgets its start within about one and a half periods of the cutoff.
  const auto wanted = static_cast<Eigen::Index>(std::ceil(1.5 * frame_rate_hz / cutoff_hz));
  const Eigen::Index pad = std::min(wanted, frames - 1);
  Eigen::MatrixXd padded(samples.rows(), frames + 2 * pad);
  padded.middleCols(pad, frames) = samples;
  for (Eigen::Index i = 1; i <= pad; ++i) {
    padded.col(pad - i) = 2 * samples.col(0) - samples.col(i);
    padded.col(pad + frames - 1 + i) = 2 * samples.col(frames - 1) - samples.col(frames - 1 - i);
  }
  const Biquad filter(cutoff_hz / frame_rate_hz);
  filter.Run(&padded);
  padded = padded.rowwise().reverse().eval();
  filter.Run(&padded);
  padded = padded.rowwise().reverse().eval();
  return padded.middleCols(pad, frames);
}

}  // namespace morphograph
