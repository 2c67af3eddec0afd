#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "graph/walk_boundary.h"
#include "synthesis/control/control_terms.h"
#include "synthesis/control/floor_area.h"
#include "synthesis/control/floor_path.h"
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
  /// Whether any mixture component may be met about as often as all walks of the style meet it, not as the drawn walker does.
  bool any_steps = false;

  bool stops() const { return to != WalkBoundary::kWalking; }
};

/// Speed of a profile at a time.
double SpeedAt(const std::vector<SpeedTerm::Knot>& profile, double time_s);

/// a - b, to within half a turn (rad).
double SignedAngle(double a, double b);

}  // namespace morphograph
