#pragma once

#include <utility>
#include <vector>

namespace morphograph {

/// Value below which the `part` in [0, 1] of the values lies, linear between neighbours.
/// @throws std::invalid_argument for no value or a part outside [0, 1].
double Quantile(std::vector<double> values, double part);

inline double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

}  // namespace morphograph
