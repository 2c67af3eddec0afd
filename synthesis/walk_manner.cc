#include "synthesis/walk_manner.h"

#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "synthesis/draw_index.h"

namespace morphograph {
namespace {

// Correlation of a manner with itself a step later: half of it is left after some 46 steps. Faster, and a clip of ten seconds would already
// mix manners that no walker has together.
constexpr double kKept = 0.985;

// How much alike the mixture components are that two walks keep to in a primitive, 0 to 1.
double Likeness(const WalkManner& manner, const MotionPrimitive& primitive, size_t id, int walk) {
  const Eigen::VectorXd& mine = manner.components[id];
  const Eigen::VectorXd other = primitive.manner.components.col(walk).cast<double>();
  return mine.dot(other) / (mine.norm() * other.norm());
}

// Draws among all walks of the style, or by their likeness to one; `mean`, if given, is what m would be on average, without its noise.
WalkManner Draw(const MotionGraph& graph, int style, MetAt met, const WalkManner* like, std::mt19937_64& rng, WalkManner* mean = nullptr) {
  const size_t count = static_cast<size_t>(graph.primitive_count());
  WalkManner drawn{std::vector<Eigen::VectorXd>(count), std::vector<Eigen::VectorXd>(count)};
  std::vector<double> weights;  // of every captured walk, over the primitives
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MannerModel& manner = graph.primitive(p).manner;
    if (graph.primitive(p).style_index != style || manner.empty()) continue;
    weights.resize(manner.steps.size(), 0);
    for (size_t walk = 0; walk < weights.size(); ++walk) {
      const double alike = like ? Likeness(*like, graph.primitive(p), static_cast<size_t>(p), static_cast<int>(walk)) : 1;
      weights[walk] += alike * (met == MetAt::kTime ? manner.seconds[walk] : manner.steps[walk]);
    }
  }
  if (mean) {
    const Eigen::Map<const Eigen::VectorXd> shares(weights.data(), static_cast<Eigen::Index>(weights.size()));
    mean->m.assign(count, {});
    for (int p = 0; p < graph.primitive_count() && shares.sum() > 0; ++p) {
      const MannerModel& manner = graph.primitive(p).manner;
      if (graph.primitive(p).style_index != style || manner.empty()) continue;
      mean->m[static_cast<size_t>(p)] = (manner.captured * shares.cast<float>()).cast<double>() / shares.sum();
    }
  }
  const int walk = DrawIndex(weights, rng);
  if (walk < 0) return drawn;
  boost::random::normal_distribution<double> normal;
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MannerModel& manner = graph.primitive(p).manner;
    if (graph.primitive(p).style_index != style || manner.empty()) continue;
    const double n = manner.steps[static_cast<size_t>(walk)];
    drawn.components[static_cast<size_t>(p)] = manner.components.col(walk).cast<double>();
    Eigen::VectorXd& m = drawn.m[static_cast<size_t>(p)];
    m = manner.captured.col(walk).cast<double>();
    for (Eigen::Index d = 0; d < m.size(); ++d) {
      const double b = manner.share[d];
      // The variance of a manner given n of its steps: b - b^2 / (b + (1 - b) / n).
      if (b > 0) m[d] += std::sqrt(b * (1 - b) / (n * b + 1 - b)) * normal(rng);
    }
  }
  return drawn;
}

}  // namespace

WalkManner DrawManner(const MotionGraph& graph, int style, MetAt met, std::mt19937_64& rng) { return Draw(graph, style, met, nullptr, rng); }

void DriftManner(const MotionGraph& graph, int style, std::mt19937_64& rng, WalkManner* manner) {
  WalkManner mean;  // of all that may be drawn: what is left of a manner and what is new of it must not add up to more than it
  const WalkManner other = Draw(graph, style, MetAt::kStep, manner, rng, &mean);
  const double fresh = std::sqrt(1 - kKept * kKept);
  for (size_t p = 0; p < manner->m.size(); ++p) {
    if (manner->m[p].size() == 0 || other.m[p].size() == 0) continue;
    manner->m[p] = mean.m[p] + kKept * (manner->m[p] - mean.m[p]) + fresh * (other.m[p] - mean.m[p]);
    manner->components[p] = kKept * manner->components[p] + (1 - kKept) * other.components[p];
  }
}

}  // namespace morphograph
