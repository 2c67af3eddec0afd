#pragma once

#include <Eigen/Core>
#include <optional>

#include "api/request/findings.h"
#include "synthesis/control/control_terms.h"

namespace morphograph {

/// What else a request says about its clip, as far as it does.
struct ClipExtent {
  std::optional<double> duration_s;
  std::optional<int> steps;
  std::optional<Eigen::Vector2d> start_m;
};

/// Finds what no model could meet, since the request contradicts itself: ends that lie apart, moments after the clip's end, places in areas
/// that are kept out of, areas without an inside. Each is a 422 at the field that would have to give way, with the nearest that could be.
/// What depends on the model (how fast it walks, what its hands reach) is for the synthesiser to say.
void CheckControlTerms(const ControlTerms& terms, const ClipExtent& clip, Findings* findings);

/// Metres along a line, from point to point.
double LineLength(const std::vector<Eigen::Vector2d>& points_m);

}  // namespace morphograph
