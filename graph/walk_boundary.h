#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "graph/motion_graph.h"

namespace morphograph {

/// What a clip begins out of, or ends in.
enum class WalkBoundary {
  kWalking,   // cut out of a walk that goes on
  kSlowStep,  // a first (last) step that still gathers (already loses) speed
  kStanding,  // a standstill
};

std::string_view WalkBoundaryName(WalkBoundary boundary);  // "walking", "slow_step", "standing"
std::optional<WalkBoundary> ParseWalkBoundary(std::string_view name);

/// By key frame: a landing is inside the walk, a double stance that bounds a start or an end is a slow step's, standing is standing.
WalkBoundary BoundaryOf(KeyframeLabel label);
/// What a primitive leads out of and into.
WalkBoundary BeginsIn(const MotionPrimitive& primitive);
WalkBoundary EndsIn(const MotionPrimitive& primitive);

/// From landing to landing: neither a start nor an end.
inline bool IsSteady(const MotionPrimitive& primitive) {
  return BeginsIn(primitive) == WalkBoundary::kWalking && EndsIn(primitive) == WalkBoundary::kWalking;
}

/// How walks of one style can begin and end; both hold kWalking where the style walks at all. In the order of WalkBoundary.
struct StyleBoundaries {
  std::string action;
  std::string style;  // empty where the data has no styles
  std::vector<WalkBoundary> starts;
  std::vector<WalkBoundary> ends;
};

/// One entry a style, in the order of the graph's styles. A start counts when a transition leads from it into steady walking, an end
/// when one leads from steady walking into it.
std::vector<StyleBoundaries> FindBoundaries(const MotionGraph& graph);

}  // namespace morphograph
