#include "synthesis/control/steered_synthesis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <optional>
#include <type_traits>

#include "synthesis/control/foot_landings.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_clip.h"

namespace morphograph {
namespace {

constexpr int kAttempts = 8;
constexpr double kDawdling = 1.15;   // a walker's own steps may take this many times as long as any of the style
constexpr int kLostWays = 3;         // plans that end nowhere before a request is given up that none has met yet
constexpr double kBudget = 1e6;        // of a request, in units of SteerBudget
constexpr double kOddSwing = 0.1;      // beyond the range of swings, in parts of it: rather than that, another walk is drawn
constexpr double kLookAhead_s = 2;  // of a walk, to see which foot it lifts first

// For people: "0.1234 m", "12.3 degrees".
std::string Quantity(double value, const std::string& unit) {
  char text[64];
  if (unit == "rad") {
    std::snprintf(text, sizeof text, "%.1f degrees", value * 180 / std::numbers::pi);
  } else {
    std::snprintf(text, sizeof text, "%.4f %s", value, unit.c_str());
  }
  return text;
}

std::string Reached(const ControlOutcome& outcome) {
  if (outcome.reached.empty()) return "";
  if (outcome.unit == "rad" && outcome.reached.size() == 1) return ", at " + Quantity(outcome.reached[0], "rad");
  std::string text;
  for (const double value : outcome.reached) {
    char number[32];
    std::snprintf(number, sizeof number, "%.3f", value);
    text += (text.empty() ? ", at [" : ", ") + std::string(number);
  }
  return text + "]";
}

std::string Why(const ControlOutcome& outcome) {
  if (!std::isfinite(outcome.residual)) return "no walk found does it so often, or for so long";
  return "the nearest walk found misses it by " + Quantity(outcome.residual, outcome.unit) + Reached(outcome) + "; its tolerance is " +
         Quantity(outcome.tolerance, outcome.unit);
}

// Moments past a clip's end cannot be met, and must not be taken for its last frame.
std::vector<UnmetField> MomentsPastTheEnd(const ControlProblem& problem, const WalkPlan& plan) {
  const double end_s = (plan.frames - 0.5) / problem.frame_rate_hz;
  // Steps past the end are there for the last cross-fade only; a clip of whole steps ends within a frame after the last.
  const double all_s = plan.frames / problem.frame_rate_hz;
  const auto within = std::count_if(plan.places.begin(), plan.places.end(), [&](const KeyframePlace& place) { return place[kPlaceTime] < all_s; });
  const int last = static_cast<int>(within) - 1;
  const int first = plan.places.front()[kPlaceTime] < -0.5 / problem.frame_rate_hz ? 1 : 0;  // a clip of readings begins inside of a step
  std::vector<UnmetField> unmet;
  const auto time = [&](const std::string& pointer, double value) {
    if (value > end_s) unmet.push_back({pointer, "the clip ends at " + Quantity((plan.frames - 1) / problem.frame_rate_hz, "s")});
  };
  const auto moment = [&](const std::string& pointer, const ControlMoment& at) {
    if (at.time_s) time(pointer + "/time", *at.time_s);
    if (at.keyframe && (*at.keyframe < first || *at.keyframe > last))
      unmet.push_back({pointer + "/keyframe", "the clip has key frames " + std::to_string(first) + " to " + std::to_string(last)});
  };
  const auto& constraints = problem.request.control.constraints;
  for (size_t i = 0; i < constraints.size(); ++i) {
    const std::string pointer = "/constraints/" + std::to_string(i);
    std::visit(
        [&](const auto& term) {
          using Term = std::decay_t<decltype(term)>;
          if constexpr (std::is_same_v<Term, LookAtTerm>) {
            time(pointer + "/to", term.to_s);
          } else if constexpr (std::is_same_v<Term, TrajectoryTerm>) {
            if (!term.times_s.empty()) time(pointer, term.times_s.back());
          } else if constexpr (!std::is_same_v<Term, FootstepTerm> && !std::is_same_v<Term, KeepOutTerm>) {
            moment(pointer, term.at);
          }
        },
        constraints[i]);
  }
  return unmet;
}

// Residual in tolerances; areas, which have none, in centimetres.
double InTolerances(const ControlOutcome& outcome) {
  return std::min(1e3, outcome.tolerance > 0 ? outcome.residual / outcome.tolerance : 100 * outcome.residual);
}

double Misses(const SteeredWalk& walk) {
  double misses = 0;
  for (const ControlOutcome& outcome : walk.outcomes) {
    if (!outcome.met) misses += 1 + InTolerances(outcome) / 1e4;
  }
  return misses;
}

// Whether the clip of a planned walk has a planted interval of the foot that is lifted first: only its contacts can say.
bool ShowsRearFoot(const ControlProblem& problem, const WalkPlan& plan, int side) {
  std::vector<DrawnStep> steps;
  double time = 0;
  for (const WalkStep& step : plan.steps) {
    StepShape shape = problem.graph.primitive(step.primitive).Shape(step.latent);
    const double length = shape.duration_s * problem.frame_rate_hz;
    steps.push_back({step, std::move(shape), time, time + length});
    time += length;
  }
  const int frames = std::min(plan.frames, static_cast<int>(kLookAhead_s * problem.frame_rate_hz));
  const MotionClip clip = MakeWalkClip(problem.graph, steps, std::max(2, frames), problem.frame_rate_hz, problem.guide.start);
  for (const ContactInterval& interval : DetectContacts(clip).intervals) {
    if ((interval.foot == Foot::kLeft ? 0 : 1) == side) return interval.first < steps[0].end / 2;
  }
  return false;
}

// Plans a walk whose feet are put down in turn as foot steps count them.
WalkPlan PlanSteps(ControlProblem* problem, int effort, KinematicsCache* kinematics, SteerBudget* budget, std::mt19937_64& rng) {
  WalkGuide& guide = problem->guide;
  WalkPlan plan = PlanWalk(problem->graph, guide, effort, kinematics, budget, rng);
  const int lifted = LandingFoot(problem->graph.primitive(plan.steps[0].primitive));
  if (guide.feet.empty() || !guide.given.empty() || guide.from != WalkBoundary::kWalking || lifted < 0) return plan;
  const bool shows = ShowsRearFoot(*problem, plan, lifted);
  if (shows == (plan.first_contacts[lifted] > 1)) return plan;
  guide.counts_rear_foot = shows;
  return PlanWalk(problem->graph, guide, effort, kinematics, budget, rng);
}

// Plans a walk of the steps that its walker keeps to, or, tried again, of any: who walks straight on when untold may not have those that turn. Along a way such a
// walker would creep rather than end nowhere.
WalkPlan PlanByManner(ControlProblem* problem, int effort, KinematicsCache* kinematics, SteerBudget* budget, std::mt19937_64& rng) {
  const auto plan = [&](bool any_steps) {
    problem->guide.any_steps = any_steps;
    return PlanSteps(problem, effort, kinematics, budget, rng);
  };
  if (effort > 1) return plan(true);
  std::optional<WalkPlan> own;
  try {
    own = plan(false);
    if (!problem->guide.path) return *own;
  } catch (const UnsatisfiableRequest&) {
    if (budget->spent()) throw;
  }
  const std::optional<bool> counted = problem->guide.counts_rear_foot;
  try {
    WalkPlan any = plan(true);
    if (!own || own->frames > kDawdling * any.frames) return any;
  } catch (const UnsatisfiableRequest&) {
    if (!own) throw;
  }
  problem->guide.counts_rear_foot = counted;
  return *own;
}

}  // namespace

SteeredWalk SteerWalk(const MotionGraph& graph, const SynthesisRequest& request, int style, double frame_rate_hz, std::mt19937_64& rng) {
  ControlProblem problem = MakeControlProblem(graph, request, style, frame_rate_hz);
  KinematicsCache kinematics(graph);
  SteeredWalk best;
  std::optional<SteeredWalk> odd;  // does all that is asked, by the least odd swing
  SteerBudget budget(kBudget);
  std::vector<UnmetField> too_short;
  int lost = 0;
  std::exception_ptr why_lost;  // at first; later ones may only tell of a budget that is spent
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (attempt > 0 && budget.spent()) break;
    WalkPlan plan;
    try {
      plan = PlanByManner(&problem, attempt + 1, &kinematics, &budget, rng);
    } catch (const UnsatisfiableRequest&) {
      if (!why_lost) why_lost = std::current_exception();
      if (!best.outcomes.empty() || odd) break;  // the walks before say more of what is missing
      if (++lost < kLostWays && !budget.spent()) continue;  // a wider search may find the way
      if (too_short.empty()) std::rethrow_exception(why_lost);
      break;
    }
    if (std::vector<UnmetField> past = MomentsPastTheEnd(problem, plan); !past.empty()) {
      too_short = std::move(past);  // another walk may take longer
      continue;
    }
    SteeredWalk walk = OptimizeWalk(problem, plan, &kinematics, &budget, problem.sensors ? DrawPosterior(*problem.sensors, rng) : PosteriorDraw());
    if (walk.all_met()) {
      if (walk.swing_excess <= kOddSwing) return walk;
      if (!odd || walk.swing_excess < odd->swing_excess) odd = std::move(walk);
      continue;
    }
    if (best.outcomes.empty() || Misses(walk) < Misses(best)) best = std::move(walk);
  }
  if (odd) return std::move(*odd);
  if (best.outcomes.empty()) throw UnsatisfiableRequest(std::move(too_short));
  // The worst first: what cannot be had drags others along.
  std::erase_if(best.outcomes, [](const ControlOutcome& outcome) { return outcome.met; });
  std::stable_sort(best.outcomes.begin(), best.outcomes.end(), [](const ControlOutcome& a, const ControlOutcome& b) { return InTolerances(a) > InTolerances(b); });
  std::vector<UnmetField> unmet;
  const std::string more = budget.spent() ? "; a request that asks for so much is tried no further" : "";
  for (const ControlOutcome& outcome : best.outcomes) unmet.push_back({outcome.pointer, Why(outcome) + more});
  throw UnsatisfiableRequest(std::move(unmet));
}

}  // namespace morphograph
