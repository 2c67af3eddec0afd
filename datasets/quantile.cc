#include "datasets/quantile.h"

#include <algorithm>
#include <stdexcept>

namespace morphograph {

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) throw std::invalid_argument("Quantile: no value given");
  if (!(part >= 0 && part <= 1)) throw std::invalid_argument("Quantile: part outside [0, 1]");
  const double place = part * static_cast<double>(values.size() - 1);
  const size_t below = static_cast<size_t>(place);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(values.begin(), at, values.end());
  if (below + 1 == values.size()) return *at;
  const double next = *std::min_element(at + 1, values.end());
  return *at + (place - static_cast<double>(below)) * (next - *at);
}

}  // namespace morphograph
