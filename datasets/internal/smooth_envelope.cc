#include "datasets/internal/smooth_envelope.h"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <cmath>

namespace morphograph {
namespace {

// Mean over [i - reach, i + reach] with the given weight by distance.
template <typename Weight>
std::vector<double> Windowed(const std::vector<double>& values, int reach, const Weight& weight) {
  const int count = static_cast<int>(values.size());
  std::vector<double> weights(2 * static_cast<size_t>(reach) + 1);
  double total = 0;
  for (int d = -reach; d <= reach; ++d) total += weights[d + reach] = weight(d);
  std::vector<double> means(values.size());
  for (int i = 0; i < count; ++i) {
    double sum = 0;
    for (int d = -reach; d <= reach; ++d) sum += weights[d + reach] * values[std::clamp(i + d, 0, count - 1)];
    means[i] = sum / total;
  }
  return means;
}

}  // namespace

std::vector<double> SmoothEnvelope(const std::vector<double>& values, int radius) {
  const int count = static_cast<int>(values.size());
  std::vector<double> widest(values.size());
  for (int i = 0; i < count; ++i) {
    const int first = std::max(0, i - radius), last = std::min(count - 1, i + radius);
    widest[i] = *std::max_element(values.begin() + first, values.begin() + last + 1);
  }
  return Windowed(widest, radius, [radius](int d) {
    return 1 + std::cos(boost::math::double_constants::pi * d / (radius + 1));
  });
}

std::vector<double> GaussianSmoothed(const std::vector<double>& values, double deviation_samples) {
  if (deviation_samples < 1e-3) return values;
  return Windowed(values, static_cast<int>(std::ceil(3 * deviation_samples)), [deviation_samples](int d) {
    return std::exp(-0.5 * d * d / (deviation_samples * deviation_samples));
  });
}

}  // namespace morphograph
