#include "synthesis/walk_manner.h"

#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "synthesis/draw_index.h"

namespace morphograph {
namespace {

// Correlation of a manner with itself a step later: half of it is left after some 23 steps, more than a captured walk holds.
constexpr double kKept = 0.97;

}  // namespace

WalkManner DrawManner(const MotionGraph& graph, int style, MetAt met, std::mt19937_64& rng) {
  WalkManner drawn(static_cast<size_t>(graph.primitive_count()));
  std::vector<double> weights;  // of every captured walk, over the primitives
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MannerModel& manner = graph.primitive(p).manner;
    if (graph.primitive(p).style_index != style || manner.empty()) continue;
    weights.resize(manner.steps.size(), 0);
    for (size_t walk = 0; walk < weights.size(); ++walk) weights[walk] += met == MetAt::kTime ? manner.seconds[walk] : manner.steps[walk];
  }
  const int walk = DrawIndex(weights, rng);
  if (walk < 0) return drawn;
  boost::random::normal_distribution<double> normal;
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MannerModel& manner = graph.primitive(p).manner;
    if (graph.primitive(p).style_index != style || manner.empty()) continue;
    const double n = manner.steps[static_cast<size_t>(walk)];
    Eigen::VectorXd& m = drawn[static_cast<size_t>(p)];
    m = manner.captured.col(walk).cast<double>();
    for (Eigen::Index d = 0; d < m.size(); ++d) {
      const double b = manner.share[d];
      // The variance of a manner given n of its steps: b - b^2 / (b + (1 - b) / n).
      if (b > 0) m[d] += std::sqrt(b * (1 - b) / (n * b + 1 - b)) * normal(rng);
    }
  }
  return drawn;
}

void DriftManner(const MotionGraph& graph, int style, std::mt19937_64& rng, WalkManner* manner) {
  const WalkManner other = DrawManner(graph, style, MetAt::kStep, rng);
  const double fresh = std::sqrt(1 - kKept * kKept);
  for (size_t p = 0; p < manner->size(); ++p) {
    if ((*manner)[p].size() > 0) (*manner)[p] = kKept * (*manner)[p] + fresh * other[p];
  }
}

}  // namespace morphograph
