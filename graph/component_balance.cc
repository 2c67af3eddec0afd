#include "graph/component_balance.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "graph/walk_boundary.h"

namespace morphograph {
namespace {

constexpr int kRounds = 40;       // of scaling
constexpr int kSteps = 60;        // until a walk is as good as stationary
constexpr double kRarest = 1e-4;  // a component that is met less is not to be forced

// The steady primitives of one style, and the walks that their manners were learned from.
struct SteadyStyle {
  std::vector<int> primitives;
  std::vector<GraphEdge*> edges;  // between them
  std::vector<double> walks;      // steps of every captured walk; a single 1 without manners
};

double Factor(const MotionPrimitive& primitive, size_t walk, int component) {
  if (primitive.manner.empty()) return 1;
  return static_cast<double>(primitive.manner.components(component, static_cast<Eigen::Index>(walk)));
}

// How often each component of each primitive is met by walks of one manner, summing to 1 over all. `met` is where to begin, and the result.
using Met = std::map<int, Eigen::VectorXd>;  // by primitive
void MakeStationary(const SteadyStyle& style, const std::vector<FittedPrimitive>& fitted, size_t walk, Met* met) {
  for (int step = 0; step < kSteps; ++step) {
    Met next;
    double sum = 0;
    for (const int p : style.primitives) next[p] = 0.5 * met->at(p);  // half stays: left and right alternate, the mean over both is asked for
    for (const GraphEdge* edge : style.edges) {
      const Eigen::MatrixXd& chances = edge->model.component_chances;
      const MotionPrimitive& to = fitted[static_cast<size_t>(edge->to)].primitive;
      Eigen::VectorXd factors(chances.cols());
      for (int c = 0; c < factors.size(); ++c) factors[c] = Factor(to, walk, c);
      for (Eigen::Index from = 0; from < chances.rows(); ++from) {
        const Eigen::VectorXd row = chances.row(from).transpose().cwiseProduct(factors);
        if (row.sum() > 0) next[edge->to] += 0.5 * edge->model.probability * met->at(edge->from)[from] / row.sum() * row;
      }
    }
    for (const auto& [p, values] : next) sum += values.sum();
    if (!(sum > 0)) return;
    for (auto& [p, values] : next) values /= sum;
    *met = std::move(next);
  }
}

Met FromWeights(const SteadyStyle& style, const std::vector<FittedPrimitive>& fitted) {
  Met met;
  for (const int p : style.primitives) {
    const GaussianMixture& mixture = fitted[static_cast<size_t>(p)].primitive.mixture;
    met[p].resize(mixture.size());
    for (int c = 0; c < mixture.size(); ++c) met[p][c] = std::exp(mixture.Component(c).log_weight) / static_cast<double>(style.primitives.size());
  }
  return met;
}

// Scales every walk's factors until walks of its manner meet what it has met.
void BalanceWalks(const SteadyStyle& style, std::vector<FittedPrimitive>* fitted) {
  constexpr double kMost = 2;  // of a factor, a round: components are far from independent of each other
  for (size_t walk = 0; walk < style.walks.size(); ++walk) {
    for (int round = 0; round < kRounds; ++round) {
      Met met = FromWeights(style, *fitted);
      MakeStationary(style, *fitted, walk, &met);
      for (const auto& [p, values] : met) {
        MannerModel& manner = (*fitted)[static_cast<size_t>(p)].primitive.manner;
        if (manner.empty() || manner.steps[walk] == 0) continue;
        const auto captured = manner.met.col(static_cast<Eigen::Index>(walk)).cast<double>();
        for (int c = 0; c < values.size(); ++c) {
          const double drawn = values[c] / values.sum();
          if (drawn > kRarest) manner.components(c, static_cast<Eigen::Index>(walk)) *= static_cast<float>(std::clamp(captured[c] / drawn, 1 / kMost, kMost));
        }
      }
    }
  }
}

void Balance(const std::vector<FittedPrimitive>& fitted, SteadyStyle* style) {
  for (int round = 0; round < kRounds; ++round) {
    Met mean;
    for (size_t walk = 0; walk < style->walks.size(); ++walk) {
      Met met = FromWeights(*style, fitted);
      MakeStationary(*style, fitted, walk, &met);
      for (const auto& [p, values] : met) {
        auto& sum = mean.try_emplace(p, Eigen::VectorXd::Zero(values.size())).first->second;
        sum += style->walks[walk] * values;
      }
    }
    for (GraphEdge* edge : style->edges) {
      const GaussianMixture& mixture = fitted[static_cast<size_t>(edge->to)].primitive.mixture;
      const Eigen::VectorXd& met = mean.at(edge->to);
      Eigen::MatrixXd& chances = edge->model.component_chances;
      for (int c = 0; c < mixture.size(); ++c) {
        const double drawn = met[c] / met.sum();
        if (drawn > kRarest) chances.col(c) *= std::exp(mixture.Component(c).log_weight) / drawn;
      }
      for (Eigen::Index from = 0; from < chances.rows(); ++from) chances.row(from) /= chances.row(from).sum();
    }
  }
}

}  // namespace

void BalanceComponents(std::vector<FittedPrimitive>* all, std::vector<GraphEdge>* edges) {
  const std::vector<FittedPrimitive>& fitted = *all;
  std::map<int, SteadyStyle> styles;
  for (size_t p = 0; p < fitted.size(); ++p) {
    const MotionPrimitive& primitive = fitted[p].primitive;
    if (!IsSteady(primitive)) continue;
    SteadyStyle& style = styles[primitive.style_index];
    style.primitives.push_back(static_cast<int>(p));
    if (primitive.manner.empty()) continue;
    style.walks.resize(primitive.manner.steps.size(), 0);
    for (size_t walk = 0; walk < style.walks.size(); ++walk) style.walks[walk] += primitive.manner.steps[walk];
  }
  for (GraphEdge& edge : *edges) {
    const MotionPrimitive& from = fitted[static_cast<size_t>(edge.from)].primitive;
    if (IsSteady(from) && IsSteady(fitted[static_cast<size_t>(edge.to)].primitive)) styles[from.style_index].edges.push_back(&edge);
  }
  for (auto& [index, style] : styles) {
    if (style.edges.empty()) continue;
    if (style.walks.empty()) {
      style.walks = {1};
    } else {
      BalanceWalks(style, all);
    }
    Balance(fitted, &style);
  }
}

}  // namespace morphograph
