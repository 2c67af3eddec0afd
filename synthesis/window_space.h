#pragma once

#include <Eigen/Core>

namespace morphograph {

/// The space in which sets of windows are compared: leading principal directions of a captured set, all
/// scaled by the standard deviation along the first (METHODS section 6), so that directions keep their
/// relative size.
class WindowSpace {
 public:
  static constexpr int kDirections = 32;

  /// @param windows  (D x N) of the captured set. Fewer directions are kept when D is smaller.
  /// @throws std::invalid_argument for N < 2, windows that are not finite, or windows that never vary.
  explicit WindowSpace(const Eigen::MatrixXd& windows, int directions = kDirections);

  /// @param windows  (D x N). @return (directions x N). @throws std::invalid_argument when D differs.
  Eigen::MatrixXd Project(const Eigen::MatrixXd& windows) const;

  /// Mean squared distance of windows from the span of the directions, same scale. @throws as Project.
  double MeanSquaredResidual(const Eigen::MatrixXd& windows) const;

  int directions() const { return static_cast<int>(basis_.cols()); }
  /// Fraction of the captured variance that the directions keep.
  double variance_kept() const { return variance_kept_; }

 private:
  Eigen::VectorXd mean_;   // (D)
  Eigen::MatrixXd basis_;  // (D x directions), orthonormal columns
  double first_deviation_ = 1;
  double variance_kept_ = 0;
};

}  // namespace morphograph
