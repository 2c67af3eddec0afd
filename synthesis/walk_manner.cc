#include "synthesis/walk_manner.h"

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <numeric>

#include "synthesis/draw_index.h"

namespace morphograph {
namespace {

// Correlation of a manner with itself a step later: half of it is left after some 46 steps. Faster, and a clip of ten seconds would already
// mix manners that no walker has together.
constexpr double kKept = 0.985;

// Primitives of a style that have a manner, ascending.
std::vector<size_t> WithManner(const MotionGraph& graph, int style) {
  std::vector<size_t> ids;
  for (int p = 0; p < graph.primitive_count(); ++p) {
    if (graph.primitive(p).style_index == style && !graph.primitive(p).manner.empty()) ids.push_back(static_cast<size_t>(p));
  }
  return ids;
}

const MannerModel& ModelOf(const MotionGraph& graph, size_t id) { return graph.primitive(static_cast<int>(id)).manner; }

// How much alike the mixture components are that two walks keep to in a primitive, 0 to 1. A walk that keeps to none is like all.
double Likeness(const Eigen::VectorXd& met, const MannerModel& model, size_t walk) {
  if (met.size() == 0) return 1;
  const Eigen::VectorXd other = model.met.col(static_cast<Eigen::Index>(walk)).cast<double>();
  const double cosine = met.dot(other) / (met.norm() * other.norm());
  return cosine * cosine;  // squared, those of no component in common are as good as never taken for each other
}

// Of every captured walk its steps, by how much alike its components are.
std::vector<double> LikeWalks(const MotionGraph& graph, int style, const WalkManner& manner) {
  std::vector<double> weights;
  for (const size_t p : WithManner(graph, style)) {
    const MannerModel& model = ModelOf(graph, p);
    weights.resize(model.steps.size(), 0);
    for (size_t walk = 0; walk < weights.size(); ++walk) weights[walk] += Likeness(manner.met[p], model, walk) * model.steps[walk];
  }
  return weights;
}

// The manner of a captured walk, drawn by the walks' weights, and noise for what is not known of it.
WalkManner DrawCaptured(const MotionGraph& graph, int style, const std::vector<double>& weights, std::mt19937_64& rng) {
  const size_t count = static_cast<size_t>(graph.primitive_count());
  const std::vector<Eigen::VectorXd> none(count);
  WalkManner drawn{none, none, none};
  const int walk = DrawIndex(weights, rng);
  if (walk < 0) return drawn;
  boost::random::normal_distribution<double> normal;
  for (const size_t p : WithManner(graph, style)) {
    const MannerModel& model = ModelOf(graph, p);
    const double n = model.steps[static_cast<size_t>(walk)];
    drawn.met[p] = model.met.col(walk).cast<double>();
    drawn.components[p] = model.components.col(walk).cast<double>();
    Eigen::VectorXd& m = drawn.m[p];
    m = model.captured.col(walk).cast<double>();
    for (Eigen::Index d = 0; d < m.size(); ++d) {
      const double b = model.share[d];
      // The variance of a manner given n of its steps: b - b^2 / (b + (1 - b) / n).
      if (b > 0) m[d] += std::sqrt(b * (1 - b) / (n * b + 1 - b)) * normal(rng);
    }
  }
  return drawn;
}

}  // namespace

WalkManner DrawManner(const MotionGraph& graph, int style, MetAt met, std::mt19937_64& rng) {
  std::vector<double> weights;  // of every captured walk, over the primitives
  for (const size_t p : WithManner(graph, style)) {
    const MannerModel& model = ModelOf(graph, p);
    weights.resize(model.steps.size(), 0);
    for (size_t walk = 0; walk < weights.size(); ++walk) weights[walk] += met == MetAt::kTime ? model.seconds[walk] : model.steps[walk];
  }
  return DrawCaptured(graph, style, weights, rng);
}

void FreeComponents(WalkManner* manner) {
  for (auto* of_manner : {&manner->met, &manner->components}) {
    for (Eigen::VectorXd& values : *of_manner) values.resize(0);
  }
}

bool IsFree(const WalkManner& manner) {
  return std::all_of(manner.components.begin(), manner.components.end(), [](const Eigen::VectorXd& factors) { return factors.size() == 0; });
}

void DriftManner(const MotionGraph& graph, int style, std::mt19937_64& rng, WalkManner* manner) {
  const std::vector<double> weights = LikeWalks(graph, style, *manner);
  const WalkManner other = DrawCaptured(graph, style, weights, rng);
  const Eigen::Map<const Eigen::VectorXd> shares(weights.data(), static_cast<Eigen::Index>(weights.size()));
  const double sum = shares.sum();
  if (!(sum > 0)) return;  // like no walk that is known
  const double fresh = std::sqrt(1 - kKept * kKept);
  bool prefers_any = false;
  for (const size_t p : WithManner(graph, style)) {
    if (other.m[p].size() == 0) continue;
    // What m would be on average over all that may be drawn: what is left of a manner and what is new of it must not add up to more than it.
    const Eigen::VectorXd mean = (ModelOf(graph, p).captured * shares.cast<float>()).cast<double>() / sum;
    manner->m[p] = mean + kKept * (manner->m[p] - mean) + fresh * (other.m[p] - mean);
    prefers_any = prefers_any || manner->components[p].size() > 1;
  }
  // Factors are taken over whole: a mean of several walks' would let every long walk turn as little as the mean of them.
  boost::random::uniform_01<double> chance;
  if (!prefers_any || chance(rng) >= 1 - kKept) return;
  // Metropolis and Hastings: so that walks which many others are like are not met ever more often.
  const std::vector<double> back = LikeWalks(graph, style, other);
  if (chance(rng) * std::accumulate(back.begin(), back.end(), 0.0) >= sum) return;
  manner->met = other.met;
  manner->components = other.components;
}

}  // namespace morphograph
