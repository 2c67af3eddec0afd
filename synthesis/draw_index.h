#pragma once

#include <random>
#include <vector>

namespace morphograph {

/// Index drawn with chances proportional to `weights`; -1 when none is positive.
int DrawIndex(const std::vector<double>& weights, std::mt19937_64& rng);

}  // namespace morphograph
