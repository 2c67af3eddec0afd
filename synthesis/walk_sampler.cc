#include "synthesis/walk_sampler.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "synthesis/step_track.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_rules.h"

namespace morphograph {
namespace {

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
      : graph_(graph), extent_(extent), rng_(rng), reach_(graph, extent.to) {}

  DrawnWalk Draw() {
    if (extent_.to == WalkBoundary::kWalking) return extent_.steps ? OfSteps(*extent_.steps) : OfDuration();
    return extent_.steps ? OfSteps(*extent_.steps) : OfAboutDuration();
  }

 private:
  // The first step; `allowed` says where a walk may begin.
  WalkStep FirstStep(const std::function<bool(int)>& allowed) { return DrawStart(graph_, extent_.style, extent_.from, allowed, rng_); }

  void Append(const WalkStep& step, DrawnWalk* walk) {
    StepShape shape = graph_.primitive(step.primitive).Shape(step.latent);
    const double length = shape.duration_s * extent_.frame_rate_hz;
    double start = 0;
    if (!walk->steps.empty()) {
      start = walk->steps.back().end;
    } else if (extent_.from != WalkBoundary::kWalking) {
      start = MarginBefore(shape) * length;
    }
    walk->steps.push_back({step, std::move(shape), start, start + length});
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
    const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
    WalkStep step = FirstStep([&](int p) { return LeadsOn(graph_, p); });
    while (true) {
      Append(step, &walk);
      // With a cross-fade to spare: the step after it must not be missed.
      if (walk.steps.back().end > walk.frames + CrossFadeHalfWidth(1e9, 1e9, extent_.frame_rate_hz)) return walk;
      const int edge = DrawEdge(graph_, step.primitive, goes_on, rng_);
      if (edge < 0) Stuck(step.primitive);
      step = DrawNextStep(graph_, step, edge, rng_);
    }
  }

  DrawnWalk OfAboutDuration() {
    const double wanted = WantedFrames() - 1;
    const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
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
      if (const int edge = DrawEdge(graph_, step.primitive, ends, aside); edge >= 0) {
        Append(DrawNextStep(graph_, step, edge, aside), &walk);
        const double miss = std::abs(Length(walk) - wanted);
        if (best_steps == 0 || miss < best_miss) {
          best_end = walk.steps.back();
          best_steps = walk.steps.size() - 1;
          best_miss = miss;
        }
        walk.steps.pop_back();
      }
      const int edge = DrawEdge(graph_, step.primitive, goes_on, rng_);
      if (edge < 0) break;
      step = DrawNextStep(graph_, step, edge, rng_);
    }
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
};

}  // namespace

DrawnWalk DrawWalk(const MotionGraph& graph, const WalkExtent& extent, std::mt19937_64& rng) {
  return WalkDraw(graph, extent, rng).Draw();
}

}  // namespace morphograph
