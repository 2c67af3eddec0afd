#include "synthesis/control/walk_planner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "synthesis/control/foot_landings.h"
#include "synthesis/control/guide_cost.h"
#include "synthesis/draw_index.h"
#include "synthesis/step_track.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_manner.h"
#include "synthesis/walk_rules.h"

namespace morphograph {
namespace {

constexpr int kBeamWidth = 8;
constexpr int kFirstDraws = 24;
constexpr int kDraws = 6;        // successors of each walk in the beam; half of them are bent towards what is asked
constexpr int kEndDraws = 2;     // of them that stop
constexpr double kSpare_s = 0.3;  // walked on past the end of a clip, for its last cross-fade and for steps that grow shorter

constexpr double kEndTime_s = 0.1;  // deviation of when a walk stops
constexpr double kShortestStretch_m = 0.1;
constexpr int kMostLags[] = {2, 4, 10};  // steps that walks may take without coming a stretch of the way farther: those that dawdle are taken only where there are no others
constexpr double kStopSearch_m = 2.5, kStopSearch_s = 3;

double Squared(double value) { return value * value; }

class Search {
 public:
  Search(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, SteerBudget* budget, std::mt19937_64& rng)
      : graph_(graph), guide_(guide), effort_(effort), kinematics_(*kinematics), budget_(*budget), cost_(graph, guide, kinematics, budget), rng_(rng) {}

  WalkPlan Run() {
    std::vector<PlannedWalk> start;
    if (guide_.given.empty()) {
      std::vector<PlannedStep> first;
      for (int i = 0; i < effort_ * kFirstDraws; ++i) first.push_back(First());
      if (!SpeaksOfSpeed()) KeepOneSpeed(&first);
      for (PlannedStep& planned : first) Admit(std::move(planned), &start);
    } else {
      Given(&start);
    }
    stretch_m_ = 0;
    for (const PlannedWalk& walk : start) stretch_m_ += (walk->next.head<2>() - walk->place.head<2>()).norm() / static_cast<double>(start.size());
    for (const int most_lags : kMostLags) {
      if (!finished_) Follow(start, most_lags);
    }
    if (!finished_) Fail();
    return Plan(finished_);
  }

 private:
  [[noreturn]] void Fail() const {
    if (budget_.spent()) throw UnsatisfiableRequest("/constraints", "a walk past all that is asked for takes too much work to find; ask for fewer moments, or a shorter way");
    if (guide_.stops() && guide_.steps) throw UnsatisfiableRequest("/steps", "no walk of " + std::to_string(*guide_.steps) + " steps begins and ends as asked");
    if (guide_.stops()) throw UnsatisfiableRequest("/end", "no walk found comes to such an end");
    if (guide_.path && !guide_.steps && !guide_.duration_s)
      throw UnsatisfiableRequest("/path", "its end was not reached; walks have at most " + std::to_string(kMaxSteps) + " steps");
    throw UnsatisfiableRequest("/style", "no walk of this model begins and goes on as asked");
  }

  // Follows walks until all are over.
  void Follow(const std::vector<PlannedWalk>& start, int most_lags) {
    std::map<int, std::vector<PlannedWalk>> beams;  // walks are held against those that are as far
    for (const PlannedWalk& walk : start) beams[Stage(*walk)].push_back(walk);
    while (!beams.empty() && !budget_.spent()) {
      std::vector<PlannedWalk> beam = std::move(beams.begin()->second), next;
      beams.erase(beams.begin());
      Keep(&beam);
      for (const PlannedWalk& walk : beam) {
        if (walk->steps < StepLimit() && walk->lags <= most_lags) Expand(walk, &next);
      }
      for (PlannedWalk& walk : next) beams[Stage(*walk)].push_back(std::move(walk));
    }
  }

  // Whether a walk takes as many steps as it needs to the path's end.
  bool GoesTheWay() const { return guide_.path && !guide_.duration_s && !guide_.steps; }

  // How far a walk is: by steps, or where it takes as many as it needs, by stretches of the way as long as a step. There, held against those that took as many
  // steps, a walk that waits before a bend would win over one that has been through it.
  int Stage(const PlannedStep& planned) const { return GoesTheWay() ? static_cast<int>(planned.along / std::max(stretch_m_, kShortestStretch_m)) : planned.steps; }

  // Whether what is asked says anything about how fast to walk.
  bool SpeaksOfSpeed() const { return guide_.duration_s || guide_.steps || !guide_.speeds.empty() || !guide_.places.empty() || !guide_.headings.empty() || !guide_.feet.empty(); }

  // Leaves the half of the walks that begin about as fast as one of them, which is drawn. A beam would always prefer slow walks: small steps deviate
  // little from anything. Walks are drawn as often as they are met at a time; where a way is given, and not how long it takes, they are to be had as
  // often as they are met on the way.
  void KeepOneSpeed(std::vector<PlannedStep>* walks) {
    const auto speed = [](const PlannedStep& planned) { return (planned.next.head<2>() - planned.place.head<2>()).norm() / (planned.next[kPlaceTime] - planned.place[kPlaceTime]); };
    std::vector<double> speeds;
    for (const PlannedStep& planned : *walks) speeds.push_back(speed(planned));
    const int drawn = DrawIndex(speeds, rng_);
    if (drawn < 0) return;
    const double reference = speeds[static_cast<size_t>(drawn)];
    std::stable_sort(walks->begin(), walks->end(), [&](const PlannedStep& a, const PlannedStep& b) { return std::abs(speed(a) - reference) < std::abs(speed(b) - reference); });
    walks->resize((walks->size() + 1) / 2);
  }

  int StepLimit() const {
    if (guide_.steps) return *guide_.steps + 1;
    if (guide_.duration_s) return static_cast<int>(*guide_.duration_s / 0.15) + 10;
    return std::min(kMaxSteps, static_cast<int>(guide_.path->length_m() / 0.1) + 20);
  }

  PlannedStep First() {
    PlannedStep planned;
    planned.step = DrawStart(graph_, guide_.style, guide_.from, [&](int p) { return LeadsOn(graph_, p); }, rng_);
    if (guide_.any_steps) FreeComponents(&planned.step.manner);
    double begins = 0;
    if (guide_.from != WalkBoundary::kWalking) {
      const StepShape shape = graph_.primitive(planned.step.primitive).Shape(planned.step.latent);
      begins = MarginBefore(shape) * shape.duration_s;
    }
    planned.place = {guide_.start.position_m.x(), guide_.start.position_m.y(), guide_.start.heading_rad, begins};
    if (guide_.free_heading) {
      const KeyframePlace end = kinematics_.Of(planned.step)->WayOf(planned.step.whitened, planned.place).next;
      const Eigen::Vector2d moved = end.head<2>() - planned.place.head<2>();
      const Eigen::Vector2d wanted = guide_.path->At(std::min(guide_.path->length_m(), moved.norm())) - planned.place.head<2>();
      if (moved.norm() > 0.05 && wanted.norm() > 0.05) planned.place[kPlaceHeading] += SignedAngle(HeadingOfDirection(wanted), HeadingOfDirection(moved));
    }
    CountFirstContacts(graph_, guide_, &planned);
    cost_.SetDown(&planned);
    return planned;
  }

  // The steps that are given, one after the other, until the walk is over.
  void Given(std::vector<PlannedWalk>* walks) {
    const KeyframePlace start(guide_.start.position_m.x(), guide_.start.position_m.y(), guide_.start.heading_rad, 0);
    KeyframePlace place = PlaceBefore(*kinematics_.Of(guide_.given[0]), guide_.given[0].whitened, start, guide_.given_from_s);
    if (guide_.free_heading) {
      KeyframePlace end = place;
      double way = 0;
      for (const WalkStep& step : guide_.given) {
        const KeyframePlace next = kinematics_.Of(step)->WayOf(step.whitened, end).next;
        way += (next - end).head<2>().norm();
        end = next;
      }
      const Eigen::Vector2d moved = end.head<2>() - start.head<2>(), wanted = guide_.path->At(std::min(guide_.path->length_m(), way)) - start.head<2>();
      KeyframePlace turned = start;
      if (moved.norm() > 0.05 && wanted.norm() > 0.05) turned[kPlaceHeading] += SignedAngle(HeadingOfDirection(wanted), HeadingOfDirection(moved));
      place = PlaceBefore(*kinematics_.Of(guide_.given[0]), guide_.given[0].whitened, turned, guide_.given_from_s);
    }
    PlannedWalk walk;
    for (const WalkStep& step : guide_.given) {
      PlannedStep planned;
      planned.before = walk;
      planned.step = step;
      planned.place = walk ? walk->next : place;
      planned.along = walk ? walk->along : 0;
      planned.cost = walk ? walk->cost : 0;
      planned.steps = walk ? walk->steps + 1 : 1;
      if (walk) {
        CountContacts(graph_, *walk, &planned);
      } else {
        CountFirstContacts(graph_, guide_, &planned);
      }
      cost_.SetDown(&planned);
      if (const auto end_s = EndOf(planned)) return End(std::move(planned), *end_s);
      walk = std::make_shared<const PlannedStep>(std::move(planned));
    }
    walks->push_back(walk);
  }

  // The walk is over at a time of its last step. Ends of walks that stop are at that step's end.
  void End(PlannedStep planned, double end_s) {
    planned.cost += cost_.AtEnd(planned, end_s);
    planned.end_s = end_s;
    if (!finished_ || planned.cost < finished_->cost) finished_ = std::make_shared<const PlannedStep>(std::move(planned));
  }

  // When the walk is over, if that is within its last step.
  std::optional<double> EndOf(const PlannedStep& planned) const {
    if (guide_.stops()) return std::nullopt;
    if (guide_.steps) return planned.steps < *guide_.steps ? std::nullopt : std::optional(planned.next[kPlaceTime]);
    if (guide_.duration_s) return planned.next[kPlaceTime] < *guide_.duration_s ? std::nullopt : std::optional(*guide_.duration_s);
    const double length = guide_.path->length_m();
    if (planned.along < length - 1e-6) return std::nullopt;
    // When the path's end was passed, by the projection on the last direction.
    const Eigen::Vector2d direction = guide_.path->Direction(length), end = guide_.path->At(length);
    const double from = direction.dot(planned.place.head<2>() - end), to = direction.dot(planned.next.head<2>() - end);
    const double t = to > from ? std::clamp(-from / (to - from), 0.05, 1.0) : 1;
    return planned.place[kPlaceTime] + t * (planned.next[kPlaceTime] - planned.place[kPlaceTime]);
  }

  // A walk is over, or goes on.
  void Admit(PlannedStep planned, std::vector<PlannedWalk>* walks) {
    if (const auto end_s = EndOf(planned)) {
      End(std::move(planned), *end_s);
    } else {
      walks->push_back(std::make_shared<const PlannedStep>(std::move(planned)));
    }
  }

  void Expand(const PlannedWalk& walk, std::vector<PlannedWalk>* next) {
    const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
    const auto ends = [&](int p) { return EndsIn(graph_.primitive(p)) == guide_.to; };
    if (guide_.stops() && MayStop(*walk)) {
      for (int i = 0; i < kEndDraws; ++i) {
        const int edge = DrawEdge(graph_, walk->step.primitive, ends, rng_);
        if (edge < 0) break;
        PlannedStep planned = After(walk, edge);
        const StepShape shape = graph_.primitive(planned.step.primitive).Shape(planned.step.latent);
        const double length = planned.next[kPlaceTime] + MarginAfter(shape) * shape.duration_s;
        if (guide_.duration_s) planned.cost += Squared((length - *guide_.duration_s) / kEndTime_s);
        End(std::move(planned), length);
      }
    }
    if (guide_.stops() && guide_.steps && walk->steps + 1 >= *guide_.steps) return;
    if (guide_.stops() && guide_.duration_s && walk->next[kPlaceTime] > *guide_.duration_s + kStopSearch_s) return;
    if (guide_.stops() && !guide_.duration_s && !guide_.steps && walk->along >= guide_.path->length_m() - 1e-6) return;
    for (int i = 0; i < kDraws; ++i) {
      const int edge = DrawEdge(graph_, walk->step.primitive, goes_on, rng_);
      if (edge < 0) return;
      Admit(After(walk, edge, i >= kDraws / 2), next);
    }
  }

  bool MayStop(const PlannedStep& planned) const {
    if (guide_.steps) return planned.steps + 1 == *guide_.steps;
    if (guide_.duration_s) return std::abs(planned.next[kPlaceTime] - *guide_.duration_s) < kStopSearch_s;
    return guide_.path->length_m() - planned.along < kStopSearch_m;
  }

  PlannedStep After(const PlannedWalk& walk, int edge, bool bend = false) {
    PlannedStep planned;
    planned.before = walk;
    planned.step = DrawNextStep(graph_, walk->step, edge, rng_);
    planned.place = walk->next;
    planned.along = walk->along;
    planned.cost = walk->cost;
    planned.steps = walk->steps + 1;
    CountContacts(graph_, *walk, &planned);
    if (bend) cost_.Bend(&planned);
    cost_.SetDown(&planned);
    planned.lags = GoesTheWay() && Stage(planned) <= Stage(*walk) ? walk->lags + 1 : 0;
    return planned;
  }

  void Keep(std::vector<PlannedWalk>* beam) const {
    // Of walks on the same stretch of the way those that have come farther have less before them: it costs as much as what lies behind has cost so far.
    double per_metre = 0;
    if (GoesTheWay()) {
      double cost = 0, along = 0;
      for (const PlannedWalk& walk : *beam) {
        cost += walk->cost;
        along += walk->along;
      }
      if (along > 0) per_metre = cost / along;
    }
    const auto total = [&](const PlannedWalk& walk) { return walk->cost + walk->estimate - per_metre * walk->along; };
    std::stable_sort(beam->begin(), beam->end(), [&](const PlannedWalk& a, const PlannedWalk& b) { return total(a) < total(b); });
    const auto width = static_cast<size_t>(effort_ * kBeamWidth);
    if (beam->size() > width) beam->resize(width);
  }

  WalkPlan Plan(PlannedWalk walk) {
    const double end_s = walk->end_s;
    // What was given past the end serves as well as what could be drawn.
    for (size_t k = static_cast<size_t>(walk->steps); k < guide_.given.size() && walk->next[kPlaceTime] < end_s + kSpare_s; ++k) {
      PlannedStep planned;
      planned.before = walk;
      planned.step = guide_.given[k];
      planned.place = walk->next;
      planned.along = walk->along;
      planned.steps = walk->steps + 1;
      cost_.SetDown(&planned);
      walk = std::make_shared<const PlannedStep>(std::move(planned));
    }
    if (!guide_.stops()) {
      const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
      while (walk->next[kPlaceTime] < end_s + kSpare_s) {
        const int edge = DrawEdge(graph_, walk->step.primitive, goes_on, rng_);
        if (edge < 0) break;
        walk = std::make_shared<const PlannedStep>(After(walk, edge));
      }
    }
    WalkPlan plan;
    // Steps that were asked for are not begun anew; walks that stop last until their margin is over; others end at the frame nearest to the moment.
    const double frames = end_s * guide_.frame_rate_hz;
    const bool floors = guide_.stops() || guide_.steps || guide_.duration_s;  // as of walks that are not steered
    plan.frames = 1 + std::max(1, static_cast<int>(floors ? std::floor(frames + 1e-9) : std::lround(frames)));
    plan.places.push_back(walk->next);
    plan.along_m.push_back(walk->along);
    for (const PlannedStep* planned = walk.get(); planned; planned = planned->before.get()) {
      plan.steps.push_back(planned->step);
      plan.places.push_back(planned->place);
      plan.along_m.push_back(planned->before ? planned->before->along : 0);
    }
    const PlannedStep* first = walk.get();
    while (first->before) first = first->before.get();
    std::copy(first->contacts, first->contacts + 2, plan.first_contacts);
    std::reverse(plan.steps.begin(), plan.steps.end());
    std::reverse(plan.places.begin(), plan.places.end());
    std::reverse(plan.along_m.begin(), plan.along_m.end());
    return plan;
  }

  const MotionGraph& graph_;
  const WalkGuide& guide_;
  int effort_;
  KinematicsCache& kinematics_;
  SteerBudget& budget_;
  GuideCost cost_;
  std::mt19937_64& rng_;
  double stretch_m_ = 0;  // of the way, see Stage
  PlannedWalk finished_;  // the best of those that are over
};

}  // namespace

WalkPlan PlanWalk(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, SteerBudget* budget, std::mt19937_64& rng) {
  return Search(graph, guide, effort, kinematics, budget, rng).Run();
}

}  // namespace morphograph
