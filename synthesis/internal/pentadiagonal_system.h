#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace morphograph::internal {

/// Least squares over a sequence, of sums of at most three neighbours: a symmetric positive definite system with two diagonals on either
/// side of the main one, solved by its factors L D L^T in linear time.
class PentadiagonalSystem {
 public:
  explicit PentadiagonalSystem(int size);

  /// Adds weight (sum_k coefficients[k] x[first + k])^2 to the sum of squares.
  template <std::size_t n>
  void Add(double weight, int first, const std::array<double, n>& coefficients) {
    static_assert(n <= 3);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        diagonals_[i - j][static_cast<std::size_t>(first) + j] += weight * coefficients[i] * coefficients[j];
      }
    }
  }

  /// After this, Solve; no more Add. Every x must be in some term.
  void Factor();
  /// Right side in, solution out.
  void Solve(Eigen::VectorXd* x) const;

 private:
  std::array<std::vector<double>, 3> diagonals_;  // main, first and second below; then D and L
};

}  // namespace morphograph::internal
