#include "synthesis/control/guide_cost.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "synthesis/control/foot_landings.h"
#include "synthesis/control/walk_prior.h"

namespace morphograph {
namespace {

// Deviations of what the search looks at, about a third of what the optimiser can still move without leaving what is likely.
constexpr double kHeading = 0.3, kGoal_m = 0.15, kGoalHeading = 0.15, kSpeed_m_s = 0.1, kProgress_m = 0.25, kPlace_m = 0.1;
constexpr double kStop_m = 0.05;  // of where a walk stops: steps into a standstill vary little, and one too many or too few is half a metre
constexpr double kBendAhead_s = 2.5;  // steps are bent to what is asked within this time
constexpr double kBack_m = 0.2;   // that a way may lead back along a path
constexpr size_t kMostRows = 24;  // that a step is bent by
constexpr double kAhead_m = 0.2;  // where the path leads there is where the body should turn to
constexpr double kClearance_m = 0.3;  // of the root from areas kept out of: feet and sway need room
// Units of SteerBudget: a step that is drawn and set down, and what each moment costs that it is held against.
constexpr double kStepWork = 4, kMomentWork = 0.002, kAreaWork = 0.02;

double Square(double value) { return value * value; }

// How far along a path a way of that length may lead: it may cut a bend, but not leave one out.
double Farthest(double moved_m) { return 1.3 * moved_m + 0.2; }

}  // namespace

void GuideCost::TakeWork() const {
  const size_t moments = guide_.places.size() + guide_.headings.size() + guide_.feet.size() + guide_.speeds.size();
  budget_.Take(kStepWork + kMomentWork * static_cast<double>(moments) + kAreaWork * static_cast<double>(guide_.keep_out.size()));
}

void GuideCost::Bend(PlannedStep* bent) const {
  PlannedStep& planned = *bent;
  const PlaceState next = kinematics_.Of(planned.step)->Next(planned.step.whitened, planned.place);
  const Eigen::Vector2d end = next.value.head<2>();
  const double duration = next.value[kPlaceTime] - planned.place[kPlaceTime];
  std::vector<double> misses;
  std::vector<Eigen::RowVectorXd> rows;
  const auto add = [&](double miss, const Eigen::RowVectorXd& row, double deviation) {
    misses.push_back(miss / deviation);
    rows.push_back(row / deviation);
  };
  if (guide_.path) {
    const FloorPath::Nearest at = guide_.path->NearestTo(end, planned.along - kBack_m, planned.along + Farthest((end - planned.place.head<2>()).norm()));
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
    const Eigen::Vector2d left = std::max(0.0, still) / duration * (end - planned.place.head<2>());
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
    const auto landing = LandingOf(graph_, foot, planned, planned.place.head<2>(), end);
    if (!landing || landing->steps * duration > kBendAhead_s || rows.size() + 2 > kMostRows) continue;
    const Eigen::Matrix2Xd by_latent = (1.5 + landing->steps) * next.by_latent.topRows<2>() +
                                       Eigen::Vector2d(landing->way_m.y(), -landing->way_m.x()) * next.by_latent.row(kPlaceHeading);
    const Eigen::Vector2d miss = landing->position_m - foot.position_m;
    for (int axis = 0; axis < 2; ++axis) add(miss[axis], by_latent.row(axis), landing->deviation_m());
  }
  if (rows.empty()) return;
  Eigen::MatrixXd by_latent(static_cast<Eigen::Index>(rows.size()), rows[0].size());
  for (size_t r = 0; r < rows.size(); ++r) by_latent.row(static_cast<Eigen::Index>(r)) = rows[r];
  Eigen::MatrixXd gram = by_latent * by_latent.transpose();
  gram.diagonal().array() += 1;
  const Eigen::VectorXd miss = Eigen::Map<const Eigen::VectorXd>(misses.data(), static_cast<Eigen::Index>(misses.size()));
  Eigen::VectorXd change = -by_latent.transpose() * gram.ldlt().solve(miss);
  // No farther out than captured steps, or than the step was drawn.
  const double radius = graph_.primitive(planned.step.primitive).latent_radius, drawn = planned.step.whitened.norm();
  if (const double most = std::max(radius, drawn); radius > 0 && (planned.step.whitened + change).norm() > most) {
    const double a = change.squaredNorm(), b = planned.step.whitened.dot(change), c = drawn * drawn - most * most;
    change *= std::clamp((-b + std::sqrt(std::max(0.0, b * b - a * c))) / a, 0.0, 1.0);
  }
  MoveTo(graph_, planned.step.whitened + change, &planned.step);
  planned.cost += change.squaredNorm();
}

void GuideCost::SetDown(PlannedStep* last) const {
  TakeWork();
  PlannedStep& planned = *last;
  const auto kinematics = kinematics_.Of(planned.step);
  const StepKinematics::Way way = kinematics->WayOf(planned.step.whitened, planned.place);
  planned.next = way.next;
  const Eigen::Vector2d begin = planned.place.head<2>(), middle = way.middle_m, end = planned.next.head<2>();
  const double duration = planned.next[kPlaceTime] - planned.place[kPlaceTime];
  const Eigen::Vector2d velocity = (end - begin) / duration;
  const double before = planned.along;
  if (guide_.path) {
    const double farthest = before + Farthest((end - begin).norm());
    const FloorPath::Nearest at = guide_.path->NearestTo(end, before - kBack_m, farthest);
    const FloorPath::Nearest half = guide_.path->NearestTo(middle, before - kBack_m, farthest);
    planned.along = at.along_m;
    planned.cost += (Square(at.distance_m) + Square(half.distance_m)) / Square(guide_.path_deviation_m);
    const double ahead = std::min(guide_.path->length_m(), at.along_m + kAhead_m);
    planned.cost += Square(SignedAngle(planned.next[kPlaceHeading], guide_.path->Heading(ahead)) / kHeading);
    const bool at_end = at.along_m >= guide_.path->length_m() - 1e-6;
    if (!at_end && planned.along - before < 0.3 * (end - begin).norm()) planned.cost += 4;
    if (guide_.duration_s) {
      const double expected = guide_.path->length_m() * std::min(1.0, planned.next[kPlaceTime] / *guide_.duration_s);
      planned.cost += Square((planned.along - expected) / kProgress_m);
    }
  }
  if (!guide_.speeds.empty()) {
    const double wanted = SpeedAt(guide_.speeds, (planned.place[kPlaceTime] + planned.next[kPlaceTime]) / 2);
    planned.cost += Square((velocity.norm() - wanted) / kSpeed_m_s);
  }
  planned.estimate = 0;
  const auto timed = [&](double time, auto miss_of) {
    if (time < planned.place[kPlaceTime]) return;
    // Before its time, where the walk would be if it went on as it goes, the less certain the farther off.
    const double still = std::max(0.0, time - planned.next[kPlaceTime]);
    const double cost = miss_of(std::min(time, planned.next[kPlaceTime]), still);
    (still > 0 ? planned.estimate : planned.cost) += cost;
  };
  for (const TimedPlace& wanted : guide_.places) {
    timed(wanted.time_s, [&](double time, double still) {
      const Eigen::Vector2d there = begin + velocity * (time - planned.place[kPlaceTime] + still);
      return Square(std::max(0.0, (there - wanted.position_m).norm() - wanted.reach_m) / (kPlace_m + 0.25 * still));
    });
  }
  for (const TimedHeading& wanted : guide_.headings) {
    timed(wanted.time_s, [&](double time, double still) {
      const double t = (time - planned.place[kPlaceTime]) / duration;
      const double there = planned.place[kPlaceHeading] + t * SignedAngle(planned.next[kPlaceHeading], planned.place[kPlaceHeading]);
      return Square(SignedAngle(there, wanted.heading_rad) / (kGoalHeading + 0.3 * still));
    });
  }
  for (const FootPlace& foot : guide_.feet) {
    const auto landing = LandingOf(graph_, foot, planned, begin, end);
    if (landing) (landing->steps > 0 ? planned.estimate : planned.cost) += ((landing->position_m - foot.position_m) / landing->deviation_m()).squaredNorm();
  }
  for (const FloorArea& area : guide_.keep_out) {
    for (const Eigen::Vector2d& point : {middle, end}) planned.cost += Square(std::max(0.0, area.Depth(point) + kClearance_m) / 0.1);
    planned.estimate += Square(std::max(0.0, area.Depth(end + 0.6 * velocity) + kClearance_m) / 0.2);
  }
}

double GuideCost::AtEnd(const PlannedStep& last, double end_s) const {
  const bool stops = guide_.stops();
  const double t = stops ? 1 : std::clamp((end_s - last.place[kPlaceTime]) / (last.next[kPlaceTime] - last.place[kPlaceTime]), 0.0, 1.0);
  const Eigen::Vector2d there = last.place.head<2>() + t * (last.next.head<2>() - last.place.head<2>());
  double cost = 0;
  if (guide_.goal_m) cost += Square((there - *guide_.goal_m).norm() / (stops ? kStop_m : kGoal_m));
  if (guide_.goal_heading_rad) {
    const double heading = last.place[kPlaceHeading] + t * SignedAngle(last.next[kPlaceHeading], last.place[kPlaceHeading]);
    cost += Square(SignedAngle(heading, *guide_.goal_heading_rad) / kGoalHeading);
  }
  return cost;
}

}  // namespace morphograph
