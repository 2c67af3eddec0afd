#include "synthesis/control/walk_planner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "synthesis/control/floor_area.h"
#include "synthesis/control/walk_prior.h"
#include "synthesis/step_track.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_rules.h"

namespace morphograph {
namespace {

constexpr int kBeamWidth = 8;
constexpr int kFirstDraws = 16;
constexpr int kDraws = 4;        // successors of each walk in the beam; half of them are bent towards what is asked
constexpr int kEndDraws = 2;     // of them that stop
constexpr double kSpare_s = 0.3;  // walked on past the end of a clip, for its last cross-fade and for steps that grow shorter

// Deviations of what the search looks at, about a third of what the optimiser can still move without leaving what is likely.
constexpr double kHeading = 0.3, kGoal_m = 0.15, kGoalHeading = 0.15, kSpeed_m_s = 0.1, kProgress_m = 0.25, kPlace_m = 0.1, kEndTime_s = 0.1;
constexpr double kStop_m = 0.05;  // of where a walk stops: steps into a standstill vary little, and one too many or too few is half a metre
constexpr double kBendAhead_s = 2.5;  // steps are bent to what is asked within this time
constexpr double kAhead_m = 0.2;  // where the path leads there is where the body should turn to
constexpr double kClearance_m = 0.3;  // of the root from areas kept out of: feet and sway need room
constexpr double kStopSearch_m = 2.5, kStopSearch_s = 3;

double Square(double value) { return value * value; }

double AngleBetween(double a, double b) { return std::remainder(a - b, 2 * M_PI); }

// A walk in the beam, by its last step.
struct Node {
  int parent = -1;
  WalkStep step;
  KeyframePlace place = KeyframePlace::Zero(), next = KeyframePlace::Zero();  // where the step begins and ends
  double along = 0;           // on the path, at its end
  double cost = 0;            // of what has been walked
  double estimate = 0;        // of what lies ahead
  int steps = 1;
  double end_s = 0;           // of the clip, once the walk is over
};

class Search {
 public:
  Search(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, std::mt19937_64& rng)
      : graph_(graph), guide_(guide), effort_(effort), kinematics_(*kinematics), rng_(rng) {}

  WalkPlan Run() {
    std::vector<int> beam;
    for (int i = 0; i < effort_ * kFirstDraws; ++i) {
      beam.push_back(AddFirst());
      Finish(beam.back());
    }
    Keep(&beam);
    for (int depth = 1; !beam.empty() && depth < StepLimit(); ++depth) {
      std::vector<int> next;
      for (const int walk : beam) Expand(walk, &next);
      Keep(&next);
      beam = std::move(next);
    }
    if (finished_.empty()) throw UnsatisfiableRequest(guide_.to == WalkBoundary::kWalking ? "/style" : "/end", "no walk of this model begins, goes on and ends as asked");
    return Plan(*std::min_element(finished_.begin(), finished_.end(), [&](int a, int b) { return nodes_[a].cost < nodes_[b].cost; }));
  }

 private:
  bool stops() const { return guide_.to != WalkBoundary::kWalking; }

  int StepLimit() const {
    if (guide_.steps) return *guide_.steps + 1;
    if (guide_.duration_s) return static_cast<int>(*guide_.duration_s / 0.15) + 10;
    return std::min(kMaxSteps, static_cast<int>(guide_.path->length_m() / 0.1) + 20);
  }

  int AddFirst() {
    Node node;
    node.step = DrawStart(graph_, guide_.style, guide_.from, [&](int p) { return LeadsOn(graph_, p); }, rng_);
    double begins = 0;
    if (guide_.from != WalkBoundary::kWalking) {
      const StepShape shape = graph_.primitive(node.step.primitive).Shape(node.step.latent);
      begins = MarginBefore(shape) * shape.duration_s;
    }
    node.place = {guide_.start.position_m.x(), guide_.start.position_m.y(), guide_.start.heading_rad, begins};
    if (guide_.free_heading) {
      const KeyframePlace end = kinematics_.Of(node.step)->WayOf(node.step.whitened, node.place).next;
      const Eigen::Vector2d moved = end.head<2>() - node.place.head<2>();
      const Eigen::Vector2d wanted = guide_.path->At(std::min(guide_.path->length_m(), moved.norm())) - node.place.head<2>();
      if (moved.norm() > 0.05 && wanted.norm() > 0.05) node.place[kPlaceHeading] += AngleBetween(HeadingOfDirection(wanted), HeadingOfDirection(moved));
    }
    return Add(std::move(node));
  }

  // Bends a drawn step towards what is asked: the most likely change of its latent, were its prior N(0, I) about what was drawn and the terms
  // known to within the search's deviations. Turns are rare among draws, and a path that asks for one should not have to wait for it.
  void Bend(Node* node) {
    const PlaceState next = kinematics_.Of(node->step)->Next(node->step.whitened, node->place);
    const Eigen::Vector2d end = next.value.head<2>();
    const double duration = next.value[kPlaceTime] - node->place[kPlaceTime];
    std::vector<double> misses;
    std::vector<Eigen::RowVectorXd> rows;
    const auto add = [&](double miss, const Eigen::RowVectorXd& row, double deviation) {
      misses.push_back(miss / deviation);
      rows.push_back(row / deviation);
    };
    if (guide_.path) {
      const FloorPath::Nearest at = guide_.path->NearestTo(end, node->along - 0.2, node->along + 2);
      const Eigen::Vector2d direction = guide_.path->Direction(at.along_m);
      const Eigen::RowVector2d left(direction.y(), -direction.x());
      const double ahead = std::min(guide_.path->length_m(), at.along_m + kAhead_m);
      add(left.dot(end - at.point_m), left * next.by_latent.topRows<2>(), guide_.path_deviation_m);
      add(AngleBetween(next.value[kPlaceHeading], guide_.path->Heading(ahead)), next.by_latent.row(kPlaceHeading), kHeading);
    }
    for (const TimedPlace& wanted : guide_.places) {
      const double still = wanted.time_s - next.value[kPlaceTime];
      if (still < -duration || still > kBendAhead_s) continue;
      // Where the walk would be by then; a turn of the body turns all of the way that is left.
      const Eigen::Vector2d left = std::max(0.0, still) / duration * (end - node->place.head<2>());
      const Eigen::Vector2d miss = end + left - wanted.position_m;
      const double too_far = miss.norm() - wanted.reach_m;
      if (too_far <= 0) continue;
      const Eigen::MatrixXd by_latent = (1 + std::max(0.0, still) / duration) * next.by_latent.topRows<2>() +
                                        Eigen::Vector2d(left.y(), -left.x()) * next.by_latent.row(kPlaceHeading);
      const Eigen::RowVector2d towards = miss.transpose().normalized();
      add(too_far, towards * by_latent, kPlace_m + 0.25 * std::max(0.0, still));
    }
    for (const TimedHeading& wanted : guide_.headings) {
      const double still = wanted.time_s - next.value[kPlaceTime];
      if (still < -duration || still > kBendAhead_s) continue;
      add(AngleBetween(next.value[kPlaceHeading], wanted.heading_rad), next.by_latent.row(kPlaceHeading), kGoalHeading + 0.3 * std::max(0.0, still));
    }
    if (rows.empty()) return;
    Eigen::MatrixXd by_latent(static_cast<Eigen::Index>(rows.size()), rows[0].size());
    for (size_t r = 0; r < rows.size(); ++r) by_latent.row(static_cast<Eigen::Index>(r)) = rows[r];
    Eigen::MatrixXd gram = by_latent * by_latent.transpose();
    gram.diagonal().array() += 1;
    const Eigen::VectorXd miss = Eigen::Map<const Eigen::VectorXd>(misses.data(), static_cast<Eigen::Index>(misses.size()));
    const Eigen::VectorXd change = -by_latent.transpose() * gram.ldlt().solve(miss);
    node->step = WithLatent(graph_, &nodes_[node->parent].step, node->step, node->step.whitened + change);
    node->cost += change.squaredNorm();
  }

  // Sets the step down, counts what it costs. Returns the walk's number.
  int Add(Node node) {
    const auto kinematics = kinematics_.Of(node.step);
    const StepKinematics::Way way = kinematics->WayOf(node.step.whitened, node.place);
    node.next = way.next;
    const Eigen::Vector2d begin = node.place.head<2>(), middle = way.middle_m, end = node.next.head<2>();
    const double duration = node.next[kPlaceTime] - node.place[kPlaceTime];
    const Eigen::Vector2d velocity = (end - begin) / duration;
    const double before = node.along;
    if (guide_.path) {
      const FloorPath::Nearest at = guide_.path->NearestTo(end, before - 0.2, before + 2);
      const FloorPath::Nearest half = guide_.path->NearestTo(middle, before - 0.2, before + 2);
      node.along = at.along_m;
      node.cost += (Square(at.distance_m) + Square(half.distance_m)) / Square(guide_.path_deviation_m);
      const double ahead = std::min(guide_.path->length_m(), at.along_m + kAhead_m);
      node.cost += Square(AngleBetween(node.next[kPlaceHeading], guide_.path->Heading(ahead)) / kHeading);
      const bool at_end = at.along_m >= guide_.path->length_m() - 1e-6;
      if (!at_end && node.along - before < 0.3 * (end - begin).norm()) node.cost += 4;
      if (guide_.duration_s) {
        const double expected = guide_.path->length_m() * std::min(1.0, node.next[kPlaceTime] / *guide_.duration_s);
        node.cost += Square((node.along - expected) / kProgress_m);
      }
    }
    if (!guide_.speeds.empty()) {
      const double wanted = SpeedAt(guide_.speeds, (node.place[kPlaceTime] + node.next[kPlaceTime]) / 2);
      node.cost += Square((velocity.norm() - wanted) / kSpeed_m_s);
    }
    node.estimate = 0;
    const auto timed = [&](double time, auto miss_of) {
      if (time < node.place[kPlaceTime]) return;
      // Before its time, where the walk would be if it went on as it goes, the less certain the farther off.
      const double still = std::max(0.0, time - node.next[kPlaceTime]);
      const double cost = miss_of(std::min(time, node.next[kPlaceTime]), still);
      (still > 0 ? node.estimate : node.cost) += cost;
    };
    for (const TimedPlace& wanted : guide_.places) {
      timed(wanted.time_s, [&](double time, double still) {
        const Eigen::Vector2d there = begin + velocity * (time - node.place[kPlaceTime] + still);
        return Square(std::max(0.0, (there - wanted.position_m).norm() - wanted.reach_m) / (kPlace_m + 0.25 * still));
      });
    }
    for (const TimedHeading& wanted : guide_.headings) {
      timed(wanted.time_s, [&](double time, double still) {
        const double t = (time - node.place[kPlaceTime]) / duration;
        const double there = node.place[kPlaceHeading] + t * AngleBetween(node.next[kPlaceHeading], node.place[kPlaceHeading]);
        return Square(AngleBetween(there, wanted.heading_rad) / (kGoalHeading + 0.3 * still));
      });
    }
    for (const KeepOutTerm& area : guide_.keep_out) {
      for (const Eigen::Vector2d& point : {middle, end}) node.cost += Square(std::max(0.0, DepthInside(area, point) + kClearance_m) / 0.1);
      node.estimate += Square(std::max(0.0, DepthInside(area, end + 0.6 * velocity) + kClearance_m) / 0.2);
    }
    nodes_.push_back(std::move(node));
    return static_cast<int>(nodes_.size()) - 1;
  }

  // A walk over at a time of its last step: what is missing then. Ends of walks that stop are at that step's end.
  void AddFinished(int walk, double end_s) {
    Node& node = nodes_[walk];
    const double t = stops() ? 1 : std::clamp((end_s - node.place[kPlaceTime]) / (node.next[kPlaceTime] - node.place[kPlaceTime]), 0.0, 1.0);
    const Eigen::Vector2d there = node.place.head<2>() + t * (node.next.head<2>() - node.place.head<2>());
    if (guide_.goal_m) node.cost += Square((there - *guide_.goal_m).norm() / (stops() ? kStop_m : kGoal_m));
    if (guide_.goal_heading_rad) {
      const double heading = node.place[kPlaceHeading] + t * AngleBetween(node.next[kPlaceHeading], node.place[kPlaceHeading]);
      node.cost += Square(AngleBetween(heading, *guide_.goal_heading_rad) / kGoalHeading);
    }
    node.end_s = end_s;
    finished_.push_back(walk);
  }

  // True where the walk is over within its last step.
  bool Finish(int walk) {
    const Node& node = nodes_[walk];
    if (stops()) return false;
    if (guide_.steps) {
      if (node.steps < *guide_.steps) return false;
      AddFinished(walk, node.next[kPlaceTime]);
    } else if (guide_.duration_s) {
      if (node.next[kPlaceTime] < *guide_.duration_s) return false;
      AddFinished(walk, *guide_.duration_s);
    } else {
      const double length = guide_.path->length_m();
      if (node.along < length - 1e-6) return false;
      // When the path's end was passed, by the projection on the last direction.
      const Eigen::Vector2d direction = guide_.path->Direction(length), end = guide_.path->At(length);
      const double from = direction.dot(node.place.head<2>() - end), to = direction.dot(node.next.head<2>() - end);
      const double t = to > from ? std::clamp(-from / (to - from), 0.05, 1.0) : 1;
      AddFinished(walk, node.place[kPlaceTime] + t * (node.next[kPlaceTime] - node.place[kPlaceTime]));
    }
    return true;
  }

  void Expand(int walk, std::vector<int>* next) {
    const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
    const auto ends = [&](int p) { return EndsIn(graph_.primitive(p)) == guide_.to; };
    if (stops() && MayStop(nodes_[walk])) {
      for (int i = 0; i < kEndDraws; ++i) {
        const int edge = DrawEdge(graph_, nodes_[walk].step.primitive, ends, rng_);
        if (edge < 0) break;
        const int end = AddAfter(walk, edge);
        Node& node = nodes_[end];
        const StepShape shape = graph_.primitive(node.step.primitive).Shape(node.step.latent);
        const double length = node.next[kPlaceTime] + MarginAfter(shape) * shape.duration_s;
        if (guide_.duration_s) node.cost += Square((length - *guide_.duration_s) / kEndTime_s);
        AddFinished(end, length);
      }
    }
    if (stops() && guide_.steps && nodes_[walk].steps + 1 >= *guide_.steps) return;
    if (stops() && guide_.duration_s && nodes_[walk].next[kPlaceTime] > *guide_.duration_s + kStopSearch_s) return;
    if (stops() && !guide_.duration_s && !guide_.steps && nodes_[walk].along >= guide_.path->length_m() - 1e-6) return;
    for (int i = 0; i < kDraws; ++i) {
      const int edge = DrawEdge(graph_, nodes_[walk].step.primitive, goes_on, rng_);
      if (edge < 0) return;
      const int grown = AddAfter(walk, edge, i >= kDraws / 2);
      if (!Finish(grown)) next->push_back(grown);
    }
  }

  bool MayStop(const Node& node) const {
    if (guide_.steps) return node.steps + 1 == *guide_.steps;
    if (guide_.duration_s) return std::abs(node.next[kPlaceTime] - *guide_.duration_s) < kStopSearch_s;
    return guide_.path->length_m() - node.along < kStopSearch_m;
  }

  int AddAfter(int walk, int edge, bool bend = false) {
    Node node;
    node.parent = walk;
    node.step = DrawNextStep(graph_, nodes_[walk].step, edge, rng_);
    node.place = nodes_[walk].next;
    node.along = nodes_[walk].along;
    node.cost = nodes_[walk].cost;
    node.steps = nodes_[walk].steps + 1;
    if (bend) Bend(&node);
    return Add(std::move(node));
  }

  void Keep(std::vector<int>* beam) const {
    const auto better = [&](int a, int b) {
      const double first = nodes_[a].cost + nodes_[a].estimate, second = nodes_[b].cost + nodes_[b].estimate;
      return first != second ? first < second : a < b;
    };
    std::sort(beam->begin(), beam->end(), better);
    beam->erase(std::remove_if(beam->begin(), beam->end(), [&](int walk) { return std::find(finished_.begin(), finished_.end(), walk) != finished_.end(); }),
                beam->end());
    const auto width = static_cast<size_t>(effort_ * kBeamWidth);
    if (beam->size() > width) beam->resize(width);
  }

  WalkPlan Plan(int walk) {
    const double end_s = nodes_[walk].end_s;
    if (!stops()) {
      const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
      while (nodes_[walk].next[kPlaceTime] < end_s + kSpare_s) {
        const int edge = DrawEdge(graph_, nodes_[walk].step.primitive, goes_on, rng_);
        if (edge < 0) break;
        walk = AddAfter(walk, edge);
      }
    }
    WalkPlan plan;
    // Walks that stop last until their margin is over; others end at the frame nearest to the moment.
    plan.frames = 1 + std::max(1, static_cast<int>(stops() ? std::floor(end_s * guide_.frame_rate_hz) : std::lround(end_s * guide_.frame_rate_hz)));
    plan.places.push_back(nodes_[walk].next);
    plan.along_m.push_back(nodes_[walk].along);
    for (int i = walk; i >= 0; i = nodes_[i].parent) {
      plan.steps.push_back(nodes_[i].step);
      plan.places.push_back(nodes_[i].place);
      plan.along_m.push_back(nodes_[i].parent >= 0 ? nodes_[nodes_[i].parent].along : 0);
    }
    std::reverse(plan.steps.begin(), plan.steps.end());
    std::reverse(plan.places.begin(), plan.places.end());
    std::reverse(plan.along_m.begin(), plan.along_m.end());
    return plan;
  }

  const MotionGraph& graph_;
  const WalkGuide& guide_;
  int effort_;
  KinematicsCache& kinematics_;
  std::mt19937_64& rng_;
  std::vector<Node> nodes_;
  std::vector<int> finished_;
};

}  // namespace

double SpeedAt(const std::vector<SpeedTerm::Knot>& profile, double time_s) {
  size_t i = 0;
  while (i < profile.size() && profile[i].time_s <= time_s) ++i;
  if (i == 0) return profile.front().speed_m_s;
  if (i == profile.size()) return profile.back().speed_m_s;
  const auto &a = profile[i - 1], &b = profile[i];
  return a.speed_m_s + (b.speed_m_s - a.speed_m_s) * (time_s - a.time_s) / (b.time_s - a.time_s);
}

std::shared_ptr<const StepKinematics> KinematicsCache::Of(const WalkStep& step) {
  const std::pair<int, int> key{step.primitive, step.component};
  for (const auto& [known, kinematics] : made_) {
    if (known == key) return kinematics;
  }
  const MotionPrimitive& primitive = graph_.primitive(step.primitive);
  const Eigen::Quaterniond& mean = graph_.styles()[static_cast<size_t>(primitive.style_index)].mean_rotations[static_cast<size_t>(graph_.layout().active_joints()[0])];
  made_.emplace_back(key, std::make_shared<StepKinematics>(std::make_shared<StepModel>(primitive, step.component), graph_.layout(), mean));
  return made_.back().second;
}

WalkPlan PlanWalk(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, std::mt19937_64& rng) {
  return Search(graph, guide, effort, kinematics, rng).Run();
}

}  // namespace morphograph
