#include "synthesis/internal/pentadiagonal_system.h"

namespace morphograph::internal {

PentadiagonalSystem::PentadiagonalSystem(int size) {
  for (std::vector<double>& diagonal : diagonals_) diagonal.assign(static_cast<std::size_t>(size), 0);
}

void PentadiagonalSystem::Factor() {
  auto& [d, first, second] = diagonals_;
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (i >= 1) d[i] -= first[i - 1] * first[i - 1] * d[i - 1];
    if (i >= 2) d[i] -= second[i - 2] * second[i - 2] * d[i - 2];
    if (i >= 1) first[i] -= second[i - 1] * d[i - 1] * first[i - 1];
    first[i] /= d[i];
    second[i] /= d[i];
  }
}

void PentadiagonalSystem::Solve(Eigen::VectorXd* x) const {
  const auto& [d, first, second] = diagonals_;
  const std::size_t n = d.size();
  double* const v = x->data();
  for (std::size_t i = 0; i < n; ++i) {
    if (i >= 1) v[i] -= first[i - 1] * v[i - 1];
    if (i >= 2) v[i] -= second[i - 2] * v[i - 2];
  }
  for (std::size_t i = 0; i < n; ++i) v[i] /= d[i];
  for (std::size_t i = n; i-- > 0;) {
    if (i + 1 < n) v[i] -= first[i] * v[i + 1];
    if (i + 2 < n) v[i] -= second[i] * v[i + 2];
  }
}

}  // namespace morphograph::internal
