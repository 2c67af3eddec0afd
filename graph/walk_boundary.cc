#include "graph/walk_boundary.h"

#include <algorithm>
#include <array>

namespace morphograph {
namespace {

constexpr std::array kBoundaries = {WalkBoundary::kWalking, WalkBoundary::kSlowStep, WalkBoundary::kStanding};

}  // namespace

WalkBoundary BoundaryOf(KeyframeLabel label) {
  switch (label) {
    case KeyframeLabel::kDoubleStance: return WalkBoundary::kSlowStep;
    case KeyframeLabel::kStanding: return WalkBoundary::kStanding;
    default: return WalkBoundary::kWalking;
  }
}

std::string_view WalkBoundaryName(WalkBoundary boundary) {
  switch (boundary) {
    case WalkBoundary::kSlowStep: return "slow_step";
    case WalkBoundary::kStanding: return "standing";
    default: return "walking";
  }
}

std::optional<WalkBoundary> ParseWalkBoundary(std::string_view name) {
  for (const WalkBoundary boundary : kBoundaries) {
    if (WalkBoundaryName(boundary) == name) return boundary;
  }
  return std::nullopt;
}

WalkBoundary BeginsIn(const MotionPrimitive& primitive) { return BoundaryOf(primitive.start); }
WalkBoundary EndsIn(const MotionPrimitive& primitive) { return BoundaryOf(primitive.end); }

std::vector<StyleBoundaries> FindBoundaries(const MotionGraph& graph) {
  // Steady steps that something follows: only these can be walked on from.
  const auto walks = [&](int p) { return IsSteady(graph.primitive(p)) && !graph.is_dead_end(p); };
  std::vector<StyleBoundaries> styles;
  for (size_t s = 0; s < graph.styles().size(); ++s) {
    bool starts[kBoundaries.size()] = {}, ends[kBoundaries.size()] = {};
    for (int p = 0; p < graph.primitive_count(); ++p) {
      if (graph.primitive(p).style_index != static_cast<int>(s)) continue;
      if (walks(p)) starts[0] = ends[0] = true;
      for (const int edge : graph.out_edges(p)) {
        const int next = graph.edge_to(edge);
        if (walks(next)) starts[static_cast<size_t>(BeginsIn(graph.primitive(p)))] = true;
        if (walks(p)) ends[static_cast<size_t>(EndsIn(graph.primitive(next)))] = true;
      }
    }
    StyleBoundaries& found = styles.emplace_back();
    found.action = graph.action_of(graph.styles()[s]);
    found.style = graph.styles()[s].name;
    for (const WalkBoundary boundary : kBoundaries) {
      if (starts[static_cast<size_t>(boundary)]) found.starts.push_back(boundary);
      if (ends[static_cast<size_t>(boundary)]) found.ends.push_back(boundary);
    }
  }
  return styles;
}

}  // namespace morphograph
