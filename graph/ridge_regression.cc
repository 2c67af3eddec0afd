#include "graph/ridge_regression.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "graph/internal/linear_map.h"

namespace morphograph {

RidgeRegression FitRidge(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const std::vector<int>& groups) {
  if (inputs.cols() != outputs.cols() || groups.size() != static_cast<size_t>(inputs.cols())) {
    throw std::invalid_argument("FitRidge: needs an output and a group for each input");
  }
  if (std::all_of(groups.begin(), groups.end(), [&](int group) { return group == groups.front(); })) {
    throw std::invalid_argument("FitRidge: needs two groups at least");
  }
  internal::LinearMap fit = internal::FitLinearMap(internal::SearchLinearRidges(inputs, outputs), inputs, outputs, groups);
  return {std::move(fit.map), fit.residuals.squaredNorm() / static_cast<double>(fit.residuals.size())};
}

}  // namespace morphograph
