#include "datasets/internal/cubic_spline.h"

#include <algorithm>
#include <stdexcept>

namespace morphograph {

CubicSpline::CubicSpline(std::vector<double> knots, Eigen::MatrixXd values, const Eigen::VectorXd& first_slope,
                         const Eigen::VectorXd& last_slope)
    : knots_(std::move(knots)), values_(std::move(values)) {
  const int n = static_cast<int>(knots_.size());
  if (n < 2 || values_.cols() != n || first_slope.size() != values_.rows() || last_slope.size() != values_.rows()) {
    throw std::invalid_argument("CubicSpline: " + std::to_string(n) + " knots, " + std::to_string(values_.cols()) + " values");
  }
  for (int i = 1; i < n; ++i) {
    if (!(knots_[i] > knots_[i - 1])) throw std::invalid_argument("CubicSpline: knot " + std::to_string(i) + " does not increase");
  }
  // Continuity of the second derivative: a tridiagonal, diagonally dominant system for the slopes; Thomas' elimination.
  slopes_.resize(values_.rows(), n);
  slopes_.col(0) = first_slope;
  slopes_.col(n - 1) = last_slope;
  std::vector<double> upper(n, 0.0);
  for (int i = 1; i + 1 < n; ++i) {
    const double before = 1 / (knots_[i] - knots_[i - 1]);
    const double after = 1 / (knots_[i + 1] - knots_[i]);
    Eigen::VectorXd right = 3 * (before * before * (values_.col(i) - values_.col(i - 1)) +
                                 after * after * (values_.col(i + 1) - values_.col(i)));
    if (i + 2 == n) right -= after * last_slope;
    const double diagonal = 2 * (before + after) - before * upper[i - 1];
    slopes_.col(i) = (right - before * slopes_.col(i - 1)) / diagonal;
    upper[i] = after / diagonal;
  }
  for (int i = n - 3; i >= 1; --i) slopes_.col(i) -= upper[i] * slopes_.col(i + 1);
}

CubicSpline::CubicSpline(std::vector<double> knots, const std::vector<double>& values)
    : CubicSpline(std::move(knots), Eigen::Map<const Eigen::RowVectorXd>(values.data(), static_cast<Eigen::Index>(values.size())),
                  Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)) {}

Eigen::VectorXd CubicSpline::At(double x) const {
  if (x <= knots_.front()) return values_.col(0);
  if (x >= knots_.back()) return values_.rightCols<1>();
  const auto next = std::upper_bound(knots_.begin(), knots_.end(), x);
  const int i = static_cast<int>(next - knots_.begin()) - 1;
  const double width = knots_[i + 1] - knots_[i];
  const double u = (x - knots_[i]) / width;
  const double v = 1 - u;
  return v * v * (1 + 2 * u) * values_.col(i) + u * u * (1 + 2 * v) * values_.col(i + 1) +
         width * u * v * (v * slopes_.col(i) - u * slopes_.col(i + 1));
}

}  // namespace morphograph
