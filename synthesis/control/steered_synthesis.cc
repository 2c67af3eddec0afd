#include "synthesis/control/steered_synthesis.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

constexpr int kAttempts = 4;

// For people: "0.123 m", "12.3 degrees".
std::string Quantity(double value, const std::string& unit) {
  char text[64];
  if (!std::isfinite(value)) return "never";
  if (unit == "rad") {
    std::snprintf(text, sizeof text, "%.1f degrees", value * 180 / std::numbers::pi);
  } else {
    std::snprintf(text, sizeof text, "%.3f %s", value, unit.c_str());
  }
  return text;
}

double Misses(const SteeredWalk& walk) {
  double misses = 0;
  for (const ControlOutcome& outcome : walk.outcomes) {
    if (!outcome.met) misses += 1 + std::min(1e3, outcome.tolerance > 0 ? outcome.residual / outcome.tolerance : 100 * outcome.residual) / 1e4;
  }
  return misses;
}

}  // namespace

SteeredWalk SteerWalk(const MotionGraph& graph, const SynthesisRequest& request, int style, double frame_rate_hz, std::mt19937_64& rng) {
  const ControlProblem problem = MakeControlProblem(graph, request, style, frame_rate_hz);
  KinematicsCache kinematics(graph);
  SteeredWalk best;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const WalkPlan plan = PlanWalk(graph, problem.guide, attempt + 1, &kinematics, rng);
    SteeredWalk walk = OptimizeWalk(problem, plan, &kinematics);
    if (walk.all_met()) return walk;
    if (attempt == 0 || Misses(walk) < Misses(best)) best = std::move(walk);
  }
  std::vector<UnmetField> unmet;
  for (const ControlOutcome& outcome : best.outcomes) {
    if (outcome.met) continue;
    unmet.push_back({outcome.pointer, "the nearest walk found misses it by " + Quantity(outcome.residual, outcome.unit) + "; its tolerance is " +
                                          Quantity(outcome.tolerance, outcome.unit)});
  }
  throw UnsatisfiableRequest(std::move(unmet));
}

}  // namespace morphograph
