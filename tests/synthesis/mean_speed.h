#pragma once

#include "synthesis/motion_synthesizer.h"

namespace morphograph::testing {

/// Metres of way a second; the way is measured from every tenth point to the next, so that sway counts little.
inline double MeanSpeed(const SynthesisResult& result) {
  double way_m = 0;
  for (size_t f = 10; f < result.report.path_m.size(); f += 10) way_m += (result.report.path_m[f] - result.report.path_m[f - 10]).norm();
  return way_m / result.report.duration_s;
}

}  // namespace morphograph::testing
