#include "synthesis/walk_rules.h"

#include <algorithm>
#include <vector>

#include "synthesis/draw_index.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

constexpr int kBurnInSteps = 3;  // drawn and thrown away before a clip that begins inside the walk

}  // namespace

bool WalksOn(const MotionGraph& graph, int primitive) {
  return IsSteady(graph.primitive(primitive)) && !graph.is_dead_end(primitive);
}

bool LeadsOn(const MotionGraph& graph, int primitive) {
  const std::vector<int>& edges = graph.out_edges(primitive);
  return std::any_of(edges.begin(), edges.end(), [&](int edge) { return WalksOn(graph, graph.edge_to(edge)); });
}

bool IsFirst(const MotionGraph& graph, int style, WalkBoundary from, int primitive) {
  const MotionPrimitive& model = graph.primitive(primitive);
  if (model.style_index != style) return false;
  return from == WalkBoundary::kWalking ? WalksOn(graph, primitive) : BeginsIn(model) == from;
}

int DrawEdge(const MotionGraph& graph, int primitive, const std::function<bool(int)>& allowed, std::mt19937_64& rng) {
  const std::vector<int>& edges = graph.out_edges(primitive);
  std::vector<double> weights;
  for (const int edge : edges) weights.push_back(allowed(graph.edge_to(edge)) ? graph.transition(edge).probability : 0);
  const int drawn = DrawIndex(weights, rng);
  return drawn < 0 ? -1 : edges[drawn];
}

WalkStep DrawStart(const MotionGraph& graph, int style, WalkBoundary from, const std::function<bool(int)>& allowed, std::mt19937_64& rng) {
  const bool inside = from == WalkBoundary::kWalking;
  std::vector<double> weights;
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MotionPrimitive& primitive = graph.primitive(p);
    const bool fits = IsFirst(graph, style, from, p) && (inside || allowed(p));
    weights.push_back(!fits ? 0 : inside ? primitive.initial_weight : primitive.examples);
  }
  const int drawn = DrawIndex(weights, rng);
  if (drawn < 0) {
    throw UnsatisfiableRequest("/style", "the model has no steady steps of style '" + graph.styles()[style].name + "'");
  }
  WalkStep step = DrawFirstStep(graph, drawn, rng);
  if (!inside) return step;
  const auto goes_on = [&](int p) { return WalksOn(graph, p); };
  // More of them where the walk could not be finished from here: the other foot's turn.
  for (int i = 0; i < kBurnInSteps || (i < kBurnInSteps + graph.primitive_count() && !allowed(step.primitive)); ++i) {
    const int edge = DrawEdge(graph, step.primitive, goes_on, rng);
    if (edge < 0) break;
    step = DrawNextStep(graph, step, edge, rng);
  }
  return step;
}

}  // namespace morphograph
