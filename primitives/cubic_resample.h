#pragma once

#include <Eigen/Core>

namespace morphograph {

/// Cubic spline through uniformly spaced samples, as a linear map from the samples.
///
/// Twice continuously differentiable, not-a-knot ends (the first and the last two cells share one cubic),
/// so cubics are reproduced exactly. Two samples give a line, three a parabola, one a constant. Since
/// the map is linear, its weights can be worked out once and multiplied into anything linear, such as a basis.
class UniformCubicSpline {
 public:
  /// @param samples  number of samples, >= 1, at positions 0, 1, ..., samples - 1.
  explicit UniformCubicSpline(int samples);

  int samples() const { return static_cast<int>(slopes_.rows()); }

  /// Weights (samples x positions): `values * Weights(positions)` interpolates (channels x samples) values.
  /// Positions before the first or after the last sample take its value.
  Eigen::MatrixXd Weights(const Eigen::VectorXd& positions) const;

  /// `values * Weights(positions)`, to rounding, in fewer operations where there are more channels than a few: slopes come from the
  /// tridiagonal system instead of its inverse.
  /// @throws std::invalid_argument when `values` has not one column a sample.
  Eigen::MatrixXd Interpolate(const Eigen::MatrixXd& values, const Eigen::VectorXd& positions) const;

  /// Weights of the derivative by position, (samples x positions); 0 outside the samples.
  Eigen::MatrixXd DerivativeWeights(const Eigen::VectorXd& positions) const;

 private:
  Eigen::MatrixXd slopes_;  // (samples x samples): values * slopes_ are the derivatives at the samples
};

/// Values (channels x positions) of the spline through (channels x samples) data at fractional positions.
///
/// Only samples near the positions enter: at a distance of 16 samples a spline's influence has fallen
/// below 1e-9, so long clips cost no more than short ones.
/// @throws std::invalid_argument when `data` has no columns.
Eigen::MatrixXd ResampleCubic(const Eigen::MatrixXd& data, const Eigen::VectorXd& positions);

}  // namespace morphograph
