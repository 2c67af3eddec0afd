#include "graph/action_change_fit.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>

#include "graph/step_pairs.h"

namespace morphograph {
namespace {

// Of captured steps that must have a near enough one, so that a walk of the style comes by such a step before long.
constexpr double kFewestPart = 0.05;
constexpr int kFewestNear = 4;

// The captured steps of a class, as its primitive has them.
std::vector<StepWithContacts> CapturedSteps(const TrainingSet& set, const StepClass& members, const FittedPrimitive& fitted) {
  std::vector<StepWithContacts> steps;
  for (size_t m = 0; m < members.members.size(); ++m) {
    if (!set.steps[members.members[m]].steady) continue;
    const Eigen::VectorXd latent = fitted.latents.col(static_cast<Eigen::Index>(m));
    steps.push_back({fitted.primitive.Shape(latent), fitted.primitive.Contacts(latent)});
  }
  return steps;
}

bool IsWalkClass(const TrainingSet& set, const StepClass& members) { return IsWalkStep(set.steps[members.members.front()]); }

// The fastest that step speed changes in captured walks, by style and action.
std::map<std::pair<std::string, std::string>, double> FastestChanges(const TrainingSet& set, const std::vector<FittedPrimitive>& fitted) {
  std::map<std::pair<std::string, std::string>, double> fastest;
  for (const StepPairs& pairs : FindStepPairs(set)) {
    const StepClass& from = set.classes[pairs.from];
    if (!IsWalkClass(set, from) || !IsWalkClass(set, set.classes[pairs.to])) continue;
    double& most = fastest[{from.style, from.other_action}];
    for (int i = 0; i < pairs.size(); ++i) {
      const FittedPrimitive &previous = fitted[pairs.from], &next = fitted[pairs.to];
      most = std::max(most, SpeedChange_m_s2(previous.primitive.Shape(previous.latents.col(pairs.previous[i])),
                                             next.primitive.Shape(next.latents.col(pairs.next[i]))));
    }
  }
  return fastest;
}

double HardestOf(const std::vector<StepWithContacts>& steps, const Eigen::VectorXd& channel_weights) {
  double hardest = 0;
  for (const StepWithContacts& step : steps) hardest = std::max(hardest, HardestAcceleration_m_s2(step.shape, channel_weights));
  return hardest;
}

// Tries every captured step of one class with the nearest of the other.
void TryAll(const TrainingSet& set, const MeanRotations& means, KeyframeLabel start, const std::vector<StepWithContacts>& from,
            const std::vector<StepWithContacts>& to, ActionChange* change) {
  const Foot stance = start == KeyframeLabel::kLeftStance ? Foot::kLeft : Foot::kRight;
  const double beyond = std::numeric_limits<double>::max();
  change->least = {beyond, beyond};
  for (const StepWithContacts& first : from) {
    const StepWithContacts* nearest = nullptr;
    double least_m = 0;
    for (const StepWithContacts& last : to) {
      const double apart_m = ChangeDistance_m(first.shape, last.shape, set.channel_weights);
      if (nearest && apart_m >= least_m) continue;
      nearest = &last;
      least_m = apart_m;
    }
    const StepWithContacts made = BlendSteps(set.layout, means, stance, first, *nearest);
    const ChangeEffort effort = EffortOf(first.shape, made.shape, nearest->shape, set.channel_weights);
    change->least = {std::min(change->least.speed_m_s2, effort.speed_m_s2), std::min(change->least.body_m_s2, effort.body_m_s2)};
    ++change->examples;
    if (IsWithin(effort, change->captured)) ++change->near_examples;
  }
}

std::string Numbers(const char* pattern, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, pattern, a, b);
  return text;
}

// "walk to run (elderly): left_walk_to_run needs ..."
std::string NoteOn(const ActionChange& change, bool taken) {
  std::string note = change.name + ": ";
  if (!taken) {
    note += std::to_string(change.near_examples) + " of " + std::to_string(change.examples) +
            " captured steps have one near enough of the other action; no such step";
  } else {
    note += "made for " + std::to_string(change.near_examples) + " of " + std::to_string(change.examples) +
            " captured steps that have one near enough of the other action";
  }
  note += Numbers("; speed would change by %.2f m/s2 or more (captured: up to %.2f)", change.least.speed_m_s2, change.captured.speed_m_s2);
  return note + Numbers(", the body be accelerated by %.0f m/s2 or more (up to %.0f)", change.least.body_m_s2, change.captured.body_m_s2);
}

}  // namespace

std::vector<ActionChange> FindActionChanges(const TrainingSet& set, const std::vector<FittedPrimitive>& fitted, const std::string& action,
                                            std::vector<std::string>* notes) {
  const bool one_action = std::all_of(set.classes.begin(), set.classes.end(), [&](const StepClass& c) {
    return c.other_action == set.classes.front().other_action;
  });
  if (one_action) return {};
  const auto fastest = FastestChanges(set, fitted);
  const auto fastest_of = [&](const StepClass& members) {
    const auto found = fastest.find({members.style, members.other_action});
    return found == fastest.end() ? 0.0 : found->second;
  };
  std::vector<std::vector<StepWithContacts>> captured(set.classes.size());
  std::vector<double> hardest(set.classes.size(), 0);
  for (size_t c = 0; c < set.classes.size(); ++c) {
    if (!IsWalkClass(set, set.classes[c])) continue;
    captured[c] = CapturedSteps(set, set.classes[c], fitted[c]);
    hardest[c] = HardestOf(captured[c], set.channel_weights);
  }
  std::vector<ActionChange> changes;
  for (size_t a = 0; a < set.classes.size(); ++a) {
    for (size_t b = 0; b < set.classes.size(); ++b) {
      const StepClass &from = set.classes[a], &to = set.classes[b];
      const MotionPrimitive &first = fitted[a].primitive, &last = fitted[b].primitive;
      if (from.style != to.style || from.other_action == to.other_action || captured[a].empty() || captured[b].empty()) continue;
      if (first.start != last.start || first.end != last.end) continue;
      ActionChange change;
      change.name = from.primitive + "_to_" + (to.other_action.empty() ? action : to.other_action);
      change.from = static_cast<int>(a);
      change.to = static_cast<int>(b);
      change.captured = {std::max(fastest_of(from), fastest_of(to)), std::max(hardest[a], hardest[b])};
      TryAll(set, StyleOf(set, from).mean_rotations, first.start, captured[a], captured[b], &change);
      const bool taken = change.near_examples >= std::max<double>(kFewestNear, kFewestPart * change.examples);
      ActionChange named = change;
      named.name = NameInNotes(change.name, from.style, "");
      notes->push_back(NoteOn(named, taken));
      if (taken) changes.push_back(std::move(change));
    }
  }
  return changes;
}

}  // namespace morphograph
