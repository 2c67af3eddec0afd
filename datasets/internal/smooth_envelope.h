#pragma once

#include <vector>

namespace morphograph {

/// A smooth curve that lies nowhere below `values`: their running maximum over +-`radius` samples, smoothed by a raised cosine of the same
/// radius. Zero where all of `values` within twice the radius are zero.
std::vector<double> SmoothEnvelope(const std::vector<double>& values, int radius);

/// Weighted mean over a Gaussian window; the ends are continued by their last value.
std::vector<double> GaussianSmoothed(const std::vector<double>& values, double deviation_samples);

}  // namespace morphograph
