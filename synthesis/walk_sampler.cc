#include "synthesis/walk_sampler.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "synthesis/action_changer.h"
#include "synthesis/step_track.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_rules.h"

namespace morphograph {
namespace {

constexpr int kLateSteps = 6;     // that a change of action may wait for a step from which it can be made
constexpr int kWalksToChange = 64;  // drawn until one can change its action

// For every number of steps still to come, which primitives such a walk can be at: `at(n)[p]`, n = 0 for a walk that is over. A walk
// that need not stop is over at any step; all that it needs is to go on until then.
class Reach {
 public:
  Reach(const MotionGraph& graph, WalkBoundary to) : graph_(graph) {
    auto& over = at_.emplace_back(graph.primitive_count(), false);
    for (int p = 0; p < graph.primitive_count(); ++p) {
      over[p] = to == WalkBoundary::kWalking ? WalksOn(graph, p) : EndsIn(graph.primitive(p)) == to;
    }
  }

  const std::vector<bool>& at(int steps) {
    while (static_cast<int>(at_.size()) <= steps) {
      std::vector<bool> reaches(graph_.primitive_count(), false);
      for (int p = 0; p < graph_.primitive_count(); ++p) {
        if (EndsIn(graph_.primitive(p)) != WalkBoundary::kWalking) continue;
        for (const int edge : graph_.out_edges(p)) {
          // Between its first and its last step a walk is steady.
          const int next = graph_.edge_to(edge);
          if (at_.back()[next] && (at_.size() == 1 || WalksOn(graph_, next))) reaches[p] = true;
        }
      }
      at_.push_back(std::move(reaches));
    }
    return at_[steps];
  }

 private:
  const MotionGraph& graph_;
  std::vector<std::vector<bool>> at_;
};

class WalkDraw {
 public:
  WalkDraw(const MotionGraph& graph, const WalkExtent& extent, std::mt19937_64& rng)
      : graph_(graph), extent_(extent), rng_(rng), reach_(graph, extent.to), changer_(graph, rng) {}

  /// How many of the changes the walk that was drawn has made.
  size_t changed() const { return changed_; }

  DrawnWalk Draw() {
    if (extent_.to == WalkBoundary::kWalking) return extent_.steps ? OfSteps(*extent_.steps) : OfDuration();
    return extent_.steps ? OfSteps(*extent_.steps) : OfAboutDuration();
  }

 private:
  // The first step; `allowed` says where a walk may begin.
  WalkStep FirstStep(const std::function<bool(int)>& allowed) { return DrawStart(graph_, extent_.style, extent_.from, allowed, rng_); }

  void Append(const WalkStep& step, DrawnWalk* walk) {
    std::optional<StepWithContacts> made = std::move(made_);
    made_.reset();
    StepShape shape = made ? std::move(made->shape) : graph_.primitive(step.primitive).Shape(step.latent);
    const double length = shape.duration_s * extent_.frame_rate_hz;
    double start = 0;
    if (!walk->steps.empty()) {
      start = walk->steps.back().end;
    } else if (extent_.from != WalkBoundary::kWalking) {
      start = MarginBefore(shape) * length;
    }
    walk->steps.push_back({step, std::move(shape), start, start + length});
    if (made) walk->steps.back().contacts = std::move(made->contacts);
  }

  // The step after the last one of a walk, into the next action where it is time and the step can be made. Empty where there is none, or the
  // change is overdue.
  std::optional<WalkStep> Next(const WalkStep& step, const DrawnWalk& walk) {
    if (changed_ < extent_.changes.size()) {
      const StyleChange& change = extent_.changes[changed_];
      const DrawnStep& last = walk.steps.back();
      const double length = last.end - last.start, early = change.at_s * extent_.frame_rate_hz - last.end;
      if (early <= 0.5 * length) {
        if (early < -kLateSteps * length) return std::nullopt;
        if (std::optional<ChangeTry> next = changer_.Try(step, change.style)) {
          if (next->made) ++changed_;
          made_ = std::move(next->made);
          return std::move(next->step);
        }
      }
    }
    const int edge = DrawEdge(graph_, step.primitive, [&](int p) { return WalksOn(graph_, p); }, rng_);
    if (edge < 0) return std::nullopt;
    return DrawNextStep(graph_, step, edge, rng_);
  }

  // Frames of a walk that is over: to the end of its last step, and of that one's margin where the walk stops.
  double Length(const DrawnWalk& walk) const {
    const DrawnStep& last = walk.steps.back();
    const double margin = extent_.to == WalkBoundary::kWalking ? 0 : MarginAfter(last.shape) * (last.end - last.start);
    return last.end + margin;
  }

  [[noreturn]] void Stuck(int primitive) const {
    throw UnsatisfiableRequest(extent_.steps ? "/steps" : "/duration",
                               "the model cannot walk on after '" + graph_.primitive(primitive).name + "'");
  }

  DrawnWalk OfSteps(int count) {
    const auto can = [&](int steps) {
      for (int p = 0; p < graph_.primitive_count(); ++p) {
        if (IsFirst(graph_, extent_.style, extent_.from, p) && reach_.at(steps - 1)[p]) return true;
      }
      return false;
    };
    if (!can(count)) {
      for (int off = 1; off <= graph_.primitive_count() + 2; ++off) {
        for (const int near : {count - off, count + off}) {
          if (near < 1 || !can(near)) continue;
          throw UnsatisfiableRequest("/steps", "no walk of " + std::to_string(count) + " steps begins and ends as asked; the nearest has " +
                                                   std::to_string(near));
        }
      }
      throw UnsatisfiableRequest("/steps", "no walk of about " + std::to_string(count) + " steps begins and ends as asked");
    }
    DrawnWalk walk;
    WalkStep step = FirstStep([&](int p) { return static_cast<bool>(reach_.at(count - 1)[p]); });
    for (int left = count - 1;; --left) {
      Append(step, &walk);
      if (left == 0) break;
      const std::vector<bool>& good = reach_.at(left - 1);
      const int edge =
          DrawEdge(graph_, step.primitive, [&](int p) { return good[p] && (left == 1 || WalksOn(graph_, p)); }, rng_);
      if (edge < 0) Stuck(step.primitive);
      step = DrawNextStep(graph_, step, edge, rng_);
    }
    walk.frames = static_cast<int>(std::floor(Length(walk))) + 1;
    return walk;
  }

  int WantedFrames() const { return static_cast<int>(std::floor(extent_.duration_s * extent_.frame_rate_hz + 1e-9)) + 1; }

  DrawnWalk OfDuration() {
    DrawnWalk walk;
    walk.frames = WantedFrames();
    WalkStep step = FirstStep([&](int p) { return LeadsOn(graph_, p); });
    while (true) {
      Append(step, &walk);
      // With a cross-fade to spare: the step after it must not be missed.
      if (walk.steps.back().end > walk.frames + CrossFadeHalfWidth(1e9, 1e9, extent_.frame_rate_hz)) return walk;
      std::optional<WalkStep> next = Next(step, walk);
      if (!next && changed_ < extent_.changes.size()) return walk;
      if (!next) Stuck(step.primitive);
      step = std::move(*next);
    }
  }

  DrawnWalk OfAboutDuration() {
    const double wanted = WantedFrames() - 1;
    const auto ends = [&](int p) { return EndsIn(graph_.primitive(p)) == extent_.to; };
    DrawnWalk walk;
    DrawnStep best_end;
    size_t best_steps = 0;
    double best_miss = 0;
    WalkStep step = FirstStep([&](int p) { return LeadsOn(graph_, p); });
    // At least a few steps, so that there is one to stop after however short the time.
    for (int i = 0; i < graph_.primitive_count() || walk.steps.back().end <= wanted; ++i) {
      Append(step, &walk);
      std::mt19937_64 aside = rng_;  // whether the walk stops here must not change how it goes on
      const bool may_end = changed_ == extent_.changes.size();
      if (const int edge = may_end ? DrawEdge(graph_, step.primitive, ends, aside) : -1; edge >= 0) {
        Append(DrawNextStep(graph_, step, edge, aside), &walk);
        const double miss = std::abs(Length(walk) - wanted);
        if (best_steps == 0 || miss < best_miss) {
          best_end = walk.steps.back();
          best_steps = walk.steps.size() - 1;
          best_miss = miss;
        }
        walk.steps.pop_back();
      }
      std::optional<WalkStep> next = Next(step, walk);
      if (!next) break;
      step = std::move(*next);
    }
    if (changed_ < extent_.changes.size()) return walk;
    if (best_steps == 0) throw UnsatisfiableRequest("/end", "no walk that begins as asked comes to such an end");
    walk.steps.resize(best_steps);
    walk.steps.push_back(std::move(best_end));
    walk.frames = static_cast<int>(std::floor(Length(walk))) + 1;
    return walk;
  }

  const MotionGraph& graph_;
  const WalkExtent& extent_;
  std::mt19937_64& rng_;
  Reach reach_;
  ActionChanger changer_;
  size_t changed_ = 0;                   // of the extent's changes
  std::optional<StepWithContacts> made_;  // the step to be appended, where it is made
};

}  // namespace

DrawnWalk DrawWalk(const MotionGraph& graph, const WalkExtent& extent, std::mt19937_64& rng) {
  if (extent.changes.empty()) return WalkDraw(graph, extent, rng).Draw();
  size_t most = 0;
  for (int i = 0; i < kWalksToChange; ++i) {
    WalkDraw draw(graph, extent, rng);
    DrawnWalk walk = draw.Draw();
    if (draw.changed() == extent.changes.size()) return walk;
    most = std::max(most, draw.changed());
  }
  const std::string& action = graph.action_of(graph.styles()[static_cast<size_t>(extent.changes[most].style)]);
  throw UnsatisfiableRequest("/actions/" + std::to_string(most + 1),
                             "of " + std::to_string(kWalksToChange) + " walks drawn, none came near enough to the action '" + action +
                                 "' at that time to change to it as captured steps change");
}

}  // namespace morphograph
