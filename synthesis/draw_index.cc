#include "synthesis/draw_index.h"

#include <algorithm>
#include <boost/random/uniform_01.hpp>

namespace morphograph {

int DrawIndex(const std::vector<double>& weights, std::mt19937_64& rng) {
  double total = 0;
  for (const double weight : weights) total += std::max(0.0, weight);
  if (!(total > 0)) return -1;
  double left = boost::random::uniform_01<double>()(rng) * total;
  int last = -1;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    last = static_cast<int>(i);
    left -= weights[i];
    if (left < 0) break;
  }
  return last;
}

}  // namespace morphograph
