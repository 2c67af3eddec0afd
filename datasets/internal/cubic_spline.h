#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

/// Interpolating cubic spline with continuous second derivative and given slopes at both ends; constant outside of its knots.
class CubicSpline {
 public:
  CubicSpline() = default;
  /// @param knots  strictly increasing, at least 2.
  /// @param values  (dims x knots).
  /// @param first_slope, last_slope  (dims).
  /// @throws std::invalid_argument on sizes that do not match or knots that do not increase.
  CubicSpline(std::vector<double> knots, Eigen::MatrixXd values, const Eigen::VectorXd& first_slope,
              const Eigen::VectorXd& last_slope);
  /// One dimension; slopes zero.
  CubicSpline(std::vector<double> knots, const std::vector<double>& values);

  Eigen::VectorXd At(double x) const;
  double ScalarAt(double x) const { return At(x)[0]; }

 private:
  std::vector<double> knots_;
  Eigen::MatrixXd values_, slopes_;  // (dims x knots)
};

/// Rises from 0 to 1 over [0, 1] with zero first and second derivative at both ends; constant outside.
inline double Smootherstep(double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  return x * x * x * (10 + x * (-15 + 6 * x));
}

}  // namespace morphograph
