#include "primitives/cubic_resample.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace morphograph {
namespace {

constexpr int kMarginSamples = 16;

// Slopes s of the not-a-knot spline on unit spacing solve A s = B y. Inside: s[i-1] + 4 s[i] + s[i+1] =
// 3 (y[i+1] - y[i-1]). At the ends the third derivative is continuous over the second and the last but one
// sample: s[0] - s[2] = 2 (2 y[1] - y[0] - y[2]).
Eigen::MatrixXd SlopeMatrix(int n) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n), b = Eigen::MatrixXd::Zero(n, n);
  if (n == 1) return a;
  if (n == 2) {
    b.col(0).setConstant(-1);
    b.col(1).setConstant(1);
    return b.transpose();
  }
  if (n == 3) {  // the parabola's own slopes
    b << -1.5, 2, -0.5, -0.5, 0, 0.5, 0.5, -2, 1.5;
    return b.transpose();
  }
  for (int i = 1; i + 1 < n; ++i) {
    a(i, i - 1) = 1;
    a(i, i) = 4;
    a(i, i + 1) = 1;
    b(i, i + 1) = 3;
    b(i, i - 1) = -3;
  }
  a(0, 0) = a(n - 1, n - 1) = 1;
  a(0, 2) = a(n - 1, n - 3) = -1;
  b.row(0).head(3) << -2, 4, -2;
  b.row(n - 1).tail(3) << 2, -4, 2;
  return a.partialPivLu().solve(b).transpose();
}

// values * SlopeMatrix(n), n >= 4. Taking the outer slopes out of the first and the last inner equation leaves a tridiagonal
// system for the inner ones: diagonal 4, off-diagonals 1, but 2 in the first and the last row. (channels x n)
Eigen::MatrixXd Slopes(const Eigen::MatrixXd& y) {
  const Eigen::Index n = y.cols(), last = n - 1;
  Eigen::MatrixXd slopes(y.rows(), n);
  // Right-hand sides: in the outer columns those of the end conditions, inside those of the inner equations.
  slopes.col(0) = -2 * y.col(0) + 4 * y.col(1) - 2 * y.col(2);
  slopes.col(last) = 2 * y.col(last) - 4 * y.col(last - 1) + 2 * y.col(last - 2);
  for (Eigen::Index i = 1; i < last; ++i) slopes.col(i) = 3 * (y.col(i + 1) - y.col(i - 1));
  slopes.col(1) -= slopes.col(0);
  slopes.col(last - 1) -= slopes.col(last);
  Eigen::VectorXd above(n);  // Thomas' algorithm: what is left above the diagonal
  above[1] = 2.0 / 4.0;
  slopes.col(1) /= 4.0;
  for (Eigen::Index i = 2; i < last; ++i) {
    const double below = i == last - 1 ? 2.0 : 1.0;
    const double pivot = 1.0 / (4.0 - below * above[i - 1]);
    above[i] = pivot;
    slopes.col(i) = pivot * (slopes.col(i) - below * slopes.col(i - 1));
  }
  for (Eigen::Index i = last - 2; i >= 1; --i) slopes.col(i) -= above[i] * slopes.col(i + 1);
  slopes.col(0) += slopes.col(2);
  slopes.col(last) += slopes.col(last - 2);
  return slopes;
}

}  // namespace

UniformCubicSpline::UniformCubicSpline(int samples) {
  if (samples < 1) throw std::invalid_argument("UniformCubicSpline: needs at least 1 sample, got " + std::to_string(samples));
  slopes_ = SlopeMatrix(samples);
}

Eigen::MatrixXd UniformCubicSpline::Weights(const Eigen::VectorXd& positions) const {
  const int n = samples();
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(n, positions.size());
  for (Eigen::Index k = 0; k < positions.size(); ++k) {
    const double position = std::clamp(positions[k], 0.0, n - 1.0);
    const int cell = std::clamp(static_cast<int>(position), 0, std::max(0, n - 2));
    const double t = position - cell;
    if (n == 1 || t == 0) {  // on a sample: its value, without rounding
      weights(cell, k) = 1;
      continue;
    }
    // Cubic Hermite polynomials of the cell's two values and two slopes.
    const double t2 = t * t, t3 = t2 * t;
    weights.col(k) = (t3 - 2 * t2 + t) * slopes_.col(cell) + (t3 - t2) * slopes_.col(cell + 1);
    weights(cell, k) += 2 * t3 - 3 * t2 + 1;
    weights(cell + 1, k) += -2 * t3 + 3 * t2;
  }
  return weights;
}

Eigen::MatrixXd UniformCubicSpline::Interpolate(const Eigen::MatrixXd& values, const Eigen::VectorXd& positions) const {
  const int n = samples();
  if (values.cols() != n) {
    throw std::invalid_argument("UniformCubicSpline: " + std::to_string(values.cols()) + " samples given, made for " +
                                std::to_string(n));
  }
  if (n < 4) return values * Weights(positions);
  const Eigen::MatrixXd slopes = Slopes(values);
  Eigen::MatrixXd out(values.rows(), positions.size());
  for (Eigen::Index k = 0; k < positions.size(); ++k) {
    const double position = std::clamp(positions[k], 0.0, n - 1.0);
    const int cell = std::min(static_cast<int>(position), n - 2);
    const double t = position - cell;
    const double t2 = t * t, t3 = t2 * t;
    out.col(k) = (2 * t3 - 3 * t2 + 1) * values.col(cell) + (-2 * t3 + 3 * t2) * values.col(cell + 1) +
                 (t3 - 2 * t2 + t) * slopes.col(cell) + (t3 - t2) * slopes.col(cell + 1);
  }
  return out;
}

Eigen::MatrixXd UniformCubicSpline::DerivativeWeights(const Eigen::VectorXd& positions) const {
  const int n = samples();
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(n, positions.size());
  for (Eigen::Index k = 0; k < positions.size(); ++k) {
    if (n == 1 || !(positions[k] >= 0 && positions[k] <= n - 1)) continue;
    const int cell = std::min(static_cast<int>(positions[k]), n - 2);
    const double t = positions[k] - cell;
    const double t2 = t * t;
    weights.col(k) = (3 * t2 - 4 * t + 1) * slopes_.col(cell) + (3 * t2 - 2 * t) * slopes_.col(cell + 1);
    weights(cell, k) += 6 * t2 - 6 * t;
    weights(cell + 1, k) += -6 * t2 + 6 * t;
  }
  return weights;
}

Eigen::MatrixXd ResampleCubic(const Eigen::MatrixXd& data, const Eigen::VectorXd& positions) {
  if (data.cols() < 1) throw std::invalid_argument("ResampleCubic: no samples given");
  if (positions.size() == 0) return Eigen::MatrixXd(data.rows(), 0);
  const double last_sample = static_cast<double>(data.cols() - 1);
  const auto first = static_cast<Eigen::Index>(
      std::clamp(std::floor(positions.minCoeff()) - kMarginSamples, 0.0, last_sample));
  const auto last = static_cast<Eigen::Index>(
      std::clamp(std::ceil(positions.maxCoeff()) + kMarginSamples, 0.0, last_sample));
  const Eigen::Index count = last - first + 1;
  const UniformCubicSpline spline(static_cast<int>(count));
  const Eigen::VectorXd local = positions.array() - static_cast<double>(first);
  return data.middleCols(first, count) * spline.Weights(local);
}

}  // namespace morphograph
