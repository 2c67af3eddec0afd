#pragma once

#include <optional>
#include <random>
#include <vector>

#include "synthesis/control/floor_area.h"
#include "synthesis/control/floor_path.h"
#include "synthesis/control/step_kinematics.h"
#include "synthesis/graph_walk.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// The root is to be within reach of a point on the floor at a time.
struct TimedPlace {
  double time_s = 0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double reach_m = 0;
};
struct TimedHeading {
  double time_s = 0;
  double heading_rad = 0;
};

/// A foot is to be put down at a place: in its index-th planted interval.
struct FootPlace {
  bool left = true;
  int index = 0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

/// What the search over the graph is guided by.
struct WalkGuide {
  int style = 0;
  WalkBoundary from = WalkBoundary::kWalking, to = WalkBoundary::kWalking;
  double frame_rate_hz = 30;
  StartPose start;
  bool free_heading = false;              // turned so that the first step goes along the path
  std::optional<FloorPath> path;          // to its end, from its beginning
  double path_deviation_m = 0.08;         // how near to it
  std::optional<Eigen::Vector2d> goal_m;  // where the walk is when it is over
  std::optional<double> goal_heading_rad;
  // When the walk is over: at a time, after so many steps, or (neither) at the path's end.
  std::optional<double> duration_s;
  std::optional<int> steps;
  std::vector<SpeedTerm::Knot> speeds;
  std::vector<TimedPlace> places;
  std::vector<TimedHeading> headings;
  std::vector<FloorArea> keep_out;
  // Steps that the walk begins with, and when the first of them begins; the search goes on from the last. A clip that begins inside of a step begins at `start`.
  std::vector<WalkStep> given;
  double given_from_s = 0;  // 0 or less
  std::vector<FootPlace> feet;
  /// Whether a clip that begins inside a walk counts as planted the foot that is about to be lifted; as the primitive's contacts have it, where empty.
  std::optional<bool> counts_rear_foot;
};

/// A legal walk over the graph, set down on the floor.
struct WalkPlan {
  std::vector<WalkStep> steps;
  std::vector<KeyframePlace> places;  // one more than steps: where each begins, and where the last ends
  std::vector<double> along_m;        // the same, on the guide's path
  int frames = 0;                     // of the clip; where the walk stops, its last step's margin is the end
  int first_contacts[2] = {0, 0};     // planted intervals of left and right foot that are taken to have begun before the first step ends
};

/// The foot that a step puts down at its end; -1 for steps that come to a stand.
int LandingFoot(const MotionPrimitive& primitive);

/// Makes StepKinematics once for every primitive and component of a style.
class KinematicsCache {
 public:
  KinematicsCache(const MotionGraph& graph) : graph_(graph) {}
  std::shared_ptr<const StepKinematics> Of(const WalkStep& step);

 private:
  const MotionGraph& graph_;
  std::vector<std::pair<std::pair<int, int>, std::shared_ptr<const StepKinematics>>> made_;
};

/// Finds a walk near to what is asked: a beam search over the graph whose successors are drawn from the transitions, so that every walk it
/// finds is one that might have been drawn (METHODS section 4). What is still missing is the optimiser's work.
/// @param effort  1 or more: how many times the usual number of walks are followed.
/// @throws UnsatisfiableRequest where no walk begins, goes on or ends as asked.
WalkPlan PlanWalk(const MotionGraph& graph, const WalkGuide& guide, int effort, KinematicsCache* kinematics, std::mt19937_64& rng);

/// Where a step has begun that has its root at a place at that place's time.
KeyframePlace PlaceBefore(const StepKinematics& step, const Eigen::VectorXd& whitened, const KeyframePlace& root, double begins_s);

/// Speed of a profile at a time.
double SpeedAt(const std::vector<SpeedTerm::Knot>& profile, double time_s);

}  // namespace morphograph
