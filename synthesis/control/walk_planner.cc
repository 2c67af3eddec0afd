#include "synthesis/control/walk_planner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "synthesis/control/floor_area.h"
#include "synthesis/control/walk_prior.h"
#include "synthesis/draw_index.h"
#include "synthesis/step_track.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_rules.h"

namespace morphograph {
namespace {

constexpr int kBeamWidth = 8;
constexpr int kFirstDraws = 24;
constexpr int kDraws = 4;        // successors of each walk in the beam; half of them are bent towards what is asked
constexpr int kEndDraws = 2;     // of them that stop
constexpr double kSpare_s = 0.3;  // walked on past the end of a clip, for its last cross-fade and for steps that grow shorter

// Deviations of what the search looks at, about a third of what the optimiser can still move without leaving what is likely.
constexpr double kHeading = 0.3, kGoal_m = 0.15, kGoalHeading = 0.15, kSpeed_m_s = 0.1, kProgress_m = 0.25, kPlace_m = 0.1, kEndTime_s = 0.1;
constexpr double kStop_m = 0.05;  // of where a walk stops: steps into a standstill vary little, and one too many or too few is half a metre
constexpr double kBendAhead_s = 2.5;  // steps are bent to what is asked within this time
constexpr double kBack_m = 0.2;   // that a way may lead back along a path
constexpr size_t kMostRows = 24;  // that a step is bent by
constexpr double kAhead_m = 0.2;  // where the path leads there is where the body should turn to
constexpr double kClearance_m = 0.3;  // of the root from areas kept out of: feet and sway need room
constexpr double kShortestStretch_m = 0.1;
constexpr int kMostLags[] = {2, 4, 10};  // steps that walks may take without coming a stretch of the way farther: those that dawdle are taken only where there are no others
constexpr double kFoot_m = 0.1;        // of a foot that is put down, and more for every step until then
constexpr double kHalfWidth_m = 0.08;  // of a walk: feet from the way of the root
constexpr double kShortestContact_s = 0.12;  // that counts, see ContactOptions
constexpr double kStopSearch_m = 2.5, kStopSearch_s = 3;

double Square(double value) { return value * value; }

// How far along a path a way of that length may lead: it may cut a bend, but not leave one out.
double Farthest(double moved_m) { return 1.3 * moved_m + 0.2; }

double SignedAngle(double a, double b) { return std::remainder(a - b, 2 * M_PI); }

// A walk in the beam, by its last step. Walks share the steps that they have in common; those that nobody goes on with go away.
struct Node {
  std::shared_ptr<const Node> before;
  WalkStep step;
  KeyframePlace place = KeyframePlace::Zero(), next = KeyframePlace::Zero();  // where the step begins and ends
  double along = 0;           // on the path, at its end
  double cost = 0;            // of what has been walked
  double estimate = 0;        // of what lies ahead
  int steps = 1;
  int lags = 0;               // steps since it last came a stretch of the way farther
  int contacts[2] = {0, 0};   // planted intervals that each foot has begun by the step's end
  double end_s = 0;           // of the clip, once the walk is over
};
using Walk = std::shared_ptr<const Node>;

class Search {
 public:
  Search(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, std::mt19937_64& rng)
      : graph_(graph), guide_(guide), effort_(effort), kinematics_(*kinematics), rng_(rng) {}

  WalkPlan Run() {
    std::vector<Walk> start;
    if (guide_.given.empty()) {
      std::vector<Node> first;
      for (int i = 0; i < effort_ * kFirstDraws; ++i) first.push_back(First());
      if (!SpeaksOfSpeed()) KeepOneSpeed(&first);
      for (Node& node : first) Admit(std::move(node), &start);
    } else {
      Given(&start);
    }
    stretch_m_ = 0;
    for (const Walk& walk : start) stretch_m_ += (walk->next.head<2>() - walk->place.head<2>()).norm() / static_cast<double>(start.size());
    for (const int most_lags : kMostLags) {
      if (!finished_) Follow(start, most_lags);
    }
    if (!finished_) Fail();
    return Plan(finished_);
  }

 private:
  [[noreturn]] void Fail() const {
    if (stops() && guide_.steps) throw UnsatisfiableRequest("/steps", "no walk of " + std::to_string(*guide_.steps) + " steps begins and ends as asked");
    if (stops()) throw UnsatisfiableRequest("/end", "no walk found comes to such an end");
    if (guide_.path && !guide_.steps && !guide_.duration_s)
      throw UnsatisfiableRequest("/path", "its end was not reached; walks have at most " + std::to_string(kMaxSteps) + " steps");
    throw UnsatisfiableRequest("/style", "no walk of this model begins and goes on as asked");
  }

  bool stops() const { return guide_.to != WalkBoundary::kWalking; }

  // Follows walks until all are over.
  void Follow(const std::vector<Walk>& start, int most_lags) {
    std::map<int, std::vector<Walk>> beams;  // walks are held against those that are as far
    for (const Walk& walk : start) beams[Stage(*walk)].push_back(walk);
    while (!beams.empty()) {
      std::vector<Walk> beam = std::move(beams.begin()->second), next;
      beams.erase(beams.begin());
      Keep(&beam);
      for (const Walk& walk : beam) {
        if (walk->steps < StepLimit() && walk->lags <= most_lags) Expand(walk, &next);
      }
      for (Walk& walk : next) beams[Stage(*walk)].push_back(std::move(walk));
    }
  }

  // Whether a walk takes as many steps as it needs to the path's end.
  bool GoesTheWay() const { return guide_.path && !guide_.duration_s && !guide_.steps; }

  // How far a walk is: by steps, or where it takes as many as it needs, by stretches of the way as long as a step. There, held against those that took as many
  // steps, a walk that waits before a bend would win over one that has been through it.
  int Stage(const Node& node) const { return GoesTheWay() ? static_cast<int>(node.along / std::max(stretch_m_, kShortestStretch_m)) : node.steps; }

  // Whether what is asked says anything about how fast to walk.
  bool SpeaksOfSpeed() const { return guide_.duration_s || guide_.steps || !guide_.speeds.empty() || !guide_.places.empty() || !guide_.headings.empty() || !guide_.feet.empty(); }

  // Leaves the half of the walks that begin about as fast as one of them, which is drawn. A beam would always prefer slow walks: small steps deviate
  // little from anything. Walks are drawn as often as they are met at a time; where a way is given, and not how long it takes, they are to be had as
  // often as they are met on the way.
  void KeepOneSpeed(std::vector<Node>* walks) {
    const auto speed = [](const Node& node) { return (node.next.head<2>() - node.place.head<2>()).norm() / (node.next[kPlaceTime] - node.place[kPlaceTime]); };
    std::vector<double> speeds;
    for (const Node& node : *walks) speeds.push_back(speed(node));
    const int drawn = DrawIndex(speeds, rng_);
    if (drawn < 0) return;
    const double reference = speeds[static_cast<size_t>(drawn)];
    std::stable_sort(walks->begin(), walks->end(), [&](const Node& a, const Node& b) { return std::abs(speed(a) - reference) < std::abs(speed(b) - reference); });
    walks->resize((walks->size() + 1) / 2);
  }

  int StepLimit() const {
    if (guide_.steps) return *guide_.steps + 1;
    if (guide_.duration_s) return static_cast<int>(*guide_.duration_s / 0.15) + 10;
    return std::min(kMaxSteps, static_cast<int>(guide_.path->length_m() / 0.1) + 20);
  }

  Node First() {
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
      if (moved.norm() > 0.05 && wanted.norm() > 0.05) node.place[kPlaceHeading] += SignedAngle(HeadingOfDirection(wanted), HeadingOfDirection(moved));
    }
    CountFirstContacts(&node);
    SetDown(&node);
    return node;
  }

  // The steps that are given, one after the other, until the walk is over.
  void Given(std::vector<Walk>* walks) {
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
    Walk walk;
    for (const WalkStep& step : guide_.given) {
      Node node;
      node.before = walk;
      node.step = step;
      node.place = walk ? walk->next : place;
      node.along = walk ? walk->along : 0;
      node.cost = walk ? walk->cost : 0;
      node.steps = walk ? walk->steps + 1 : 1;
      if (walk) {
        CountContacts(*walk, &node);
      } else {
        CountFirstContacts(&node);
      }
      SetDown(&node);
      if (const auto end_s = EndOf(node)) return End(std::move(node), *end_s);
      walk = std::make_shared<const Node>(std::move(node));
    }
    walks->push_back(walk);
  }

  // Which foot stands as a walk begins: from a stand both; inside a walk the one that has just been put down, and maybe the one behind it.
  void CountFirstContacts(Node* node) const {
    const MotionPrimitive& primitive = graph_.primitive(node->step.primitive);
    const int lands = LandingFoot(primitive);
    if (guide_.from != WalkBoundary::kWalking || lands < 0) {
      node->contacts[0] = node->contacts[1] = 1;
    } else {
      node->contacts[1 - lands] = 1;
      node->contacts[lands] = guide_.counts_rear_foot.value_or(StandsOn(primitive, lands, primitive.Shape(node->step.latent).duration_s)) ? 1 : 0;
    }
    if (lands >= 0) ++node->contacts[lands];
  }

  void CountContacts(const Node& before, Node* node) const {
    std::copy(before.contacts, before.contacts + 2, node->contacts);
    if (const int lands = LandingFoot(graph_.primitive(node->step.primitive)); lands >= 0) ++node->contacts[lands];
  }

  // Whether a foot stays planted after the step's first key frame for long enough to count.
  static bool StandsOn(const MotionPrimitive& primitive, int side, double duration_s) {
    for (Eigen::Index s = 0; s < kPhaseSamples; ++s) {
      const double phase = PhaseOfSample(static_cast<int>(s));
      const double chance = std::max(primitive.contacts(kPlantedChance + 2 * side, s), primitive.contacts(kPlantedChance + 2 * side + 1, s));
      if (phase > 0 && chance < 0.5) return phase * duration_s > kShortestContact_s;
    }
    return true;
  }

  // Where a foot will be put down whose turn comes, if the walk goes on as in this step; nothing where it has been put down before.
  struct Landing {
    Eigen::Vector2d position_m;
    double steps = 0;  // until then, from the step's end
    Eigen::Vector2d way_m;  // from there
  };
  std::optional<Landing> LandingOf(const FootPlace& foot, const Node& node, const Eigen::Vector2d& begin, const Eigen::Vector2d& end) const {
    const int side = foot.left ? 0 : 1;
    const int landings = foot.index + 1 - node.contacts[side];
    const bool is_its_turn = LandingFoot(graph_.primitive(node.step.primitive)) == side;  // that was over with this step
    if (landings < 0 || (landings == 0 && !is_its_turn)) return std::nullopt;
    const Eigen::Vector2d step = end - begin;
    const double length = step.norm();
    Landing landing;
    landing.steps = landings == 0 ? 0 : is_its_turn ? 2 * landings : 2 * landings - 1;
    // At a key frame the foot is half a step ahead of the root.
    landing.way_m = (landing.steps + 0.5) * step;
    if (length > 1e-6) landing.way_m += (side == 0 ? 1 : -1) * kHalfWidth_m / length * Eigen::Vector2d(step.y(), -step.x());
    landing.position_m = end + landing.way_m;
    return landing;
  }
  static double FootDeviation(const Landing& landing) { return kFoot_m * (1 + 0.5 * landing.steps); }

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
      const FloorPath::Nearest at = guide_.path->NearestTo(end, node->along - kBack_m, node->along + Farthest((end - node->place.head<2>()).norm()));
      const Eigen::Vector2d direction = guide_.path->Direction(at.along_m);
      const Eigen::RowVector2d left(direction.y(), -direction.x());
      const double ahead = std::min(guide_.path->length_m(), at.along_m + kAhead_m);
      add(left.dot(end - at.point_m), left * next.by_latent.topRows<2>(), guide_.path_deviation_m);
      add(SignedAngle(next.value[kPlaceHeading], guide_.path->Heading(ahead)), next.by_latent.row(kPlaceHeading), kHeading);
    }
    for (const TimedPlace& wanted : guide_.places) {
      const double still = wanted.time_s - next.value[kPlaceTime];
      if (still < -duration || still > kBendAhead_s || rows.size() >= kMostRows) continue;
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
      if (still < -duration || still > kBendAhead_s || rows.size() >= kMostRows) continue;
      add(SignedAngle(next.value[kPlaceHeading], wanted.heading_rad), next.by_latent.row(kPlaceHeading), kGoalHeading + 0.3 * std::max(0.0, still));
    }
    for (const FootPlace& foot : guide_.feet) {
      const auto landing = LandingOf(foot, *node, node->place.head<2>(), end);
      if (!landing || landing->steps * duration > kBendAhead_s || rows.size() + 2 > kMostRows) continue;
      const Eigen::Matrix2Xd by_latent = (1.5 + landing->steps) * next.by_latent.topRows<2>() +
                                         Eigen::Vector2d(landing->way_m.y(), -landing->way_m.x()) * next.by_latent.row(kPlaceHeading);
      const Eigen::Vector2d miss = landing->position_m - foot.position_m;
      for (int axis = 0; axis < 2; ++axis) add(miss[axis], by_latent.row(axis), FootDeviation(*landing));
    }
    if (rows.empty()) return;
    Eigen::MatrixXd by_latent(static_cast<Eigen::Index>(rows.size()), rows[0].size());
    for (size_t r = 0; r < rows.size(); ++r) by_latent.row(static_cast<Eigen::Index>(r)) = rows[r];
    Eigen::MatrixXd gram = by_latent * by_latent.transpose();
    gram.diagonal().array() += 1;
    const Eigen::VectorXd miss = Eigen::Map<const Eigen::VectorXd>(misses.data(), static_cast<Eigen::Index>(misses.size()));
    const Eigen::VectorXd change = -by_latent.transpose() * gram.ldlt().solve(miss);
    MoveTo(graph_, node->step.whitened + change, &node->step);
    node->cost += change.squaredNorm();
  }

  // Sets the last step down, and counts what it costs.
  void SetDown(Node* last) {
    Node& node = *last;
    const auto kinematics = kinematics_.Of(node.step);
    const StepKinematics::Way way = kinematics->WayOf(node.step.whitened, node.place);
    node.next = way.next;
    const Eigen::Vector2d begin = node.place.head<2>(), middle = way.middle_m, end = node.next.head<2>();
    const double duration = node.next[kPlaceTime] - node.place[kPlaceTime];
    const Eigen::Vector2d velocity = (end - begin) / duration;
    const double before = node.along;
    if (guide_.path) {
      const double farthest = before + Farthest((end - begin).norm());
      const FloorPath::Nearest at = guide_.path->NearestTo(end, before - kBack_m, farthest);
      const FloorPath::Nearest half = guide_.path->NearestTo(middle, before - kBack_m, farthest);
      node.along = at.along_m;
      node.cost += (Square(at.distance_m) + Square(half.distance_m)) / Square(guide_.path_deviation_m);
      const double ahead = std::min(guide_.path->length_m(), at.along_m + kAhead_m);
      node.cost += Square(SignedAngle(node.next[kPlaceHeading], guide_.path->Heading(ahead)) / kHeading);
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
        const double there = node.place[kPlaceHeading] + t * SignedAngle(node.next[kPlaceHeading], node.place[kPlaceHeading]);
        return Square(SignedAngle(there, wanted.heading_rad) / (kGoalHeading + 0.3 * still));
      });
    }
    for (const FootPlace& foot : guide_.feet) {
      const auto landing = LandingOf(foot, node, begin, end);
      if (landing) (landing->steps > 0 ? node.estimate : node.cost) += ((landing->position_m - foot.position_m) / FootDeviation(*landing)).squaredNorm();
    }
    for (const FloorArea& area : guide_.keep_out) {
      for (const Eigen::Vector2d& point : {middle, end}) node.cost += Square(std::max(0.0, area.Depth(point) + kClearance_m) / 0.1);
      node.estimate += Square(std::max(0.0, area.Depth(end + 0.6 * velocity) + kClearance_m) / 0.2);
    }
  }

  // The walk is over at a time of its last step: what is missing then. Ends of walks that stop are at that step's end.
  void End(Node node, double end_s) {
    const double t = stops() ? 1 : std::clamp((end_s - node.place[kPlaceTime]) / (node.next[kPlaceTime] - node.place[kPlaceTime]), 0.0, 1.0);
    const Eigen::Vector2d there = node.place.head<2>() + t * (node.next.head<2>() - node.place.head<2>());
    if (guide_.goal_m) node.cost += Square((there - *guide_.goal_m).norm() / (stops() ? kStop_m : kGoal_m));
    if (guide_.goal_heading_rad) {
      const double heading = node.place[kPlaceHeading] + t * SignedAngle(node.next[kPlaceHeading], node.place[kPlaceHeading]);
      node.cost += Square(SignedAngle(heading, *guide_.goal_heading_rad) / kGoalHeading);
    }
    node.end_s = end_s;
    if (!finished_ || node.cost < finished_->cost) finished_ = std::make_shared<const Node>(std::move(node));
  }

  // When the walk is over, if that is within its last step.
  std::optional<double> EndOf(const Node& node) const {
    if (stops()) return std::nullopt;
    if (guide_.steps) return node.steps < *guide_.steps ? std::nullopt : std::optional(node.next[kPlaceTime]);
    if (guide_.duration_s) return node.next[kPlaceTime] < *guide_.duration_s ? std::nullopt : std::optional(*guide_.duration_s);
    const double length = guide_.path->length_m();
    if (node.along < length - 1e-6) return std::nullopt;
    // When the path's end was passed, by the projection on the last direction.
    const Eigen::Vector2d direction = guide_.path->Direction(length), end = guide_.path->At(length);
    const double from = direction.dot(node.place.head<2>() - end), to = direction.dot(node.next.head<2>() - end);
    const double t = to > from ? std::clamp(-from / (to - from), 0.05, 1.0) : 1;
    return node.place[kPlaceTime] + t * (node.next[kPlaceTime] - node.place[kPlaceTime]);
  }

  // A walk is over, or goes on.
  void Admit(Node node, std::vector<Walk>* walks) {
    if (const auto end_s = EndOf(node)) {
      End(std::move(node), *end_s);
    } else {
      walks->push_back(std::make_shared<const Node>(std::move(node)));
    }
  }

  void Expand(const Walk& walk, std::vector<Walk>* next) {
    const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
    const auto ends = [&](int p) { return EndsIn(graph_.primitive(p)) == guide_.to; };
    if (stops() && MayStop(*walk)) {
      for (int i = 0; i < kEndDraws; ++i) {
        const int edge = DrawEdge(graph_, walk->step.primitive, ends, rng_);
        if (edge < 0) break;
        Node node = After(walk, edge);
        const StepShape shape = graph_.primitive(node.step.primitive).Shape(node.step.latent);
        const double length = node.next[kPlaceTime] + MarginAfter(shape) * shape.duration_s;
        if (guide_.duration_s) node.cost += Square((length - *guide_.duration_s) / kEndTime_s);
        End(std::move(node), length);
      }
    }
    if (stops() && guide_.steps && walk->steps + 1 >= *guide_.steps) return;
    if (stops() && guide_.duration_s && walk->next[kPlaceTime] > *guide_.duration_s + kStopSearch_s) return;
    if (stops() && !guide_.duration_s && !guide_.steps && walk->along >= guide_.path->length_m() - 1e-6) return;
    for (int i = 0; i < kDraws; ++i) {
      const int edge = DrawEdge(graph_, walk->step.primitive, goes_on, rng_);
      if (edge < 0) return;
      Admit(After(walk, edge, i >= kDraws / 2), next);
    }
  }

  bool MayStop(const Node& node) const {
    if (guide_.steps) return node.steps + 1 == *guide_.steps;
    if (guide_.duration_s) return std::abs(node.next[kPlaceTime] - *guide_.duration_s) < kStopSearch_s;
    return guide_.path->length_m() - node.along < kStopSearch_m;
  }

  Node After(const Walk& walk, int edge, bool bend = false) {
    Node node;
    node.before = walk;
    node.step = DrawNextStep(graph_, walk->step, edge, rng_);
    node.place = walk->next;
    node.along = walk->along;
    node.cost = walk->cost;
    node.steps = walk->steps + 1;
    CountContacts(*walk, &node);
    if (bend) Bend(&node);
    SetDown(&node);
    node.lags = GoesTheWay() && Stage(node) <= Stage(*walk) ? walk->lags + 1 : 0;
    return node;
  }

  void Keep(std::vector<Walk>* beam) const {
    // Of walks on the same stretch of the way those that have come farther have less before them: it costs as much as what lies behind has cost so far.
    double per_metre = 0;
    if (GoesTheWay()) {
      double cost = 0, along = 0;
      for (const Walk& walk : *beam) {
        cost += walk->cost;
        along += walk->along;
      }
      if (along > 0) per_metre = cost / along;
    }
    const auto total = [&](const Walk& walk) { return walk->cost + walk->estimate - per_metre * walk->along; };
    std::stable_sort(beam->begin(), beam->end(), [&](const Walk& a, const Walk& b) { return total(a) < total(b); });
    const auto width = static_cast<size_t>(effort_ * kBeamWidth);
    if (beam->size() > width) beam->resize(width);
  }

  WalkPlan Plan(Walk walk) {
    const double end_s = walk->end_s;
    // What was given past the end serves as well as what could be drawn.
    for (size_t k = static_cast<size_t>(walk->steps); k < guide_.given.size() && walk->next[kPlaceTime] < end_s + kSpare_s; ++k) {
      Node node;
      node.before = walk;
      node.step = guide_.given[k];
      node.place = walk->next;
      node.along = walk->along;
      node.steps = walk->steps + 1;
      SetDown(&node);
      walk = std::make_shared<const Node>(std::move(node));
    }
    if (!stops()) {
      const auto goes_on = [&](int p) { return WalksOn(graph_, p); };
      while (walk->next[kPlaceTime] < end_s + kSpare_s) {
        const int edge = DrawEdge(graph_, walk->step.primitive, goes_on, rng_);
        if (edge < 0) break;
        walk = std::make_shared<const Node>(After(walk, edge));
      }
    }
    WalkPlan plan;
    // Steps that were asked for are not begun anew; walks that stop last until their margin is over; others end at the frame nearest to the moment.
    const double frames = end_s * guide_.frame_rate_hz;
    const bool floors = stops() || guide_.steps || guide_.duration_s;  // as of walks that are not steered
    plan.frames = 1 + std::max(1, static_cast<int>(floors ? std::floor(frames + 1e-9) : std::lround(frames)));
    plan.places.push_back(walk->next);
    plan.along_m.push_back(walk->along);
    for (const Node* node = walk.get(); node; node = node->before.get()) {
      plan.steps.push_back(node->step);
      plan.places.push_back(node->place);
      plan.along_m.push_back(node->before ? node->before->along : 0);
    }
    const Node* first = walk.get();
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
  std::mt19937_64& rng_;
  double stretch_m_ = 0;  // of the way, see Stage
  Walk finished_;  // the best of those that are over
};

}  // namespace

KeyframePlace PlaceBefore(const StepKinematics& step, const Eigen::VectorXd& whitened, const KeyframePlace& root, double begins_s) {
  KeyframePlace place(0, 0, 0, begins_s);
  const Eigen::Vector3d there = step.Root({true, root[kPlaceTime]}, whitened, place).value;
  place[kPlaceHeading] = root[kPlaceHeading] - there[2];
  const double c = std::cos(place[kPlaceHeading]), s = std::sin(place[kPlaceHeading]);
  place[kPlaceX] = root[kPlaceX] - (c * there[0] + s * there[1]);
  place[kPlaceZ] = root[kPlaceZ] - (-s * there[0] + c * there[1]);
  return place;
}

int LandingFoot(const MotionPrimitive& primitive) {
  return primitive.end == KeyframeLabel::kLeftStance ? 0 : primitive.end == KeyframeLabel::kRightStance ? 1 : -1;
}

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
