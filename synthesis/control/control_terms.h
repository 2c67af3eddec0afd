#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "datasets/placements.h"
#include "datasets/readings.h"

namespace morphograph {

struct SensorGuide;

/// What a clip can be asked to do (METHODS section 4). Positions on the floor are (x, z), all lengths metres, angles radians.
/// A term is met where its residual, measured on the finished clip, is no more than its tolerance. Its weight says how much its squared residuals count in the
/// optimisation against those of other terms and of the steps' likelihood: above 0, usually 1.

/// The moment that a term is about: a time from the clip's start, or a key frame; key frame 0 begins the first step, and key frame n ends
/// the n-th. Exactly one of them.
struct ControlMoment {
  std::optional<double> time_s = {};
  std::optional<int> keyframe = {};
};

/// The root follows a line on the floor from its beginning to its end.
/// Residual: the 95th percentile of the root's distance from the line, over the frames (m).
struct PathTerm {
  std::vector<Eigen::Vector2d> points_m;  // two or more
  bool smooth = false;                    // a spline through the points in place of straight lines between them
  double tolerance_m = 0.10;
  double weight = 1;
};

/// Where the clip ends. Residuals: distance (m), and angle where a heading is asked for.
struct GoalTerm {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  std::optional<double> heading_rad = {};
  double tolerance_m = 0.05;
  double heading_tolerance_rad = 5 * 0.017453292519943295;
  std::optional<double> time_s = {};  // of arrival; the clip's duration, where that is given, says the same
  double weight = 1;
};

/// Speed of the root over the floor, step by step. Residual: mean over the steps of |speed of a step - wanted| (m/s).
struct SpeedTerm {
  struct Knot {
    double time_s = 0;
    double speed_m_s = 0;
  };
  std::vector<Knot> profile;  // by time, linear between knots and constant outside; one knot is a constant speed
  double tolerance_m_s = 0.10;
  double weight = 1;
};

/// A joint at a point at a moment. Residual: distance (m), over the coordinates that are given.
struct PositionTerm {
  std::string joint;  // role or the skeleton's own name
  ControlMoment at;
  Eigen::Vector3d value_m = Eigen::Vector3d::Zero();
  bool use[3] = {true, true, true};  // which coordinates count
  double tolerance_m = 0.03;
  double weight = 1;
};

/// A joint's world orientation at a moment, as a turn from the pose in which the skeleton was written down (all rotations zero).
/// Residual: angle.
struct OrientationTerm {
  std::string joint;
  ControlMoment at;
  Eigen::Quaterniond value = Eigen::Quaterniond::Identity();
  double tolerance_rad = 10 * 0.017453292519943295;
  double weight = 1;
};

/// A joint on a line in space, point by point in time. Residual: the largest distance at the given times (m).
struct TrajectoryTerm {
  std::string joint;
  std::vector<double> times_s;             // rising
  std::vector<Eigen::Vector3d> points_m;   // one a time
  double tolerance_m = 0.05;
  double weight = 1;
};

/// Heading of the pelvis at a moment. Residual: angle.
struct HeadingTerm {
  ControlMoment at;
  double value_rad = 0;
  double tolerance_rad = 5 * 0.017453292519943295;
  double weight = 1;
};

/// Where a foot is put: its index-th planted interval as the report's contacts list them, from 0. Residual: distance on the floor (m).
struct FootstepTerm {
  bool left = true;
  int index = 0;
  Eigen::Vector2d value_m = Eigen::Vector2d::Zero();
  double tolerance_m = 0.03;
  double weight = 1;
};

/// An area that neither root nor feet may enter. Residual: how deep they come (m), 0 outside.
struct KeepOutTerm {
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();  // circle, where there is no polygon
  double radius_m = 0;
  std::vector<Eigen::Vector2d> polygon_m = {};  // three or more corners, simple; either sense of turn
  double weight = 1;
};

/// The head is turned towards a point for a time. Residual: mean angle between where it faces and the point.
struct LookAtTerm {
  double from_s = 0;
  double to_s = 0;
  Eigen::Vector3d value_m = Eigen::Vector3d::Zero();
  double tolerance_rad = 10 * 0.017453292519943295;
  double weight = 1;
};

/// Joints at points given in the frame of the pelvis (origin below the hips on the floor, +Z where it heads) at a moment.
/// Residual: root mean square distance (m).
struct PoseTerm {
  ControlMoment at;
  std::vector<std::string> joints;
  std::vector<Eigen::Vector3d> values_m;
  double tolerance_m = 0.05;
  double weight = 1;
};

using Constraint = std::variant<PositionTerm, OrientationTerm, TrajectoryTerm, HeadingTerm, FootstepTerm, KeepOutTerm, LookAtTerm, PoseTerm>;

/// Readings of accelerometers on the walker, from the clip's start on (Xie 2009, Eq. 6.4; METHODS section 4): the walk is one that they make likely.
/// Residual: root mean square of the readings less those of the same sensors on the clip (m/s^2).
struct SensorTerm {
  Readings readings;                  // m/s^2, gravity included; the first sample is the clip's start
  std::vector<Placement> placements;  // one a sensor of `readings`, in order
  std::optional<double> tolerance_m_s2 = {};  // absent: any residual will do
  double weight = 1;
  std::shared_ptr<const SensorGuide> guide = {};  // made of them beforehand (MakeSensorGuide); empty: made by Synthesize()
};

/// All that one clip is asked to do.
struct ControlTerms {
  std::optional<PathTerm> path = {};
  std::optional<GoalTerm> goal = {};
  std::optional<SpeedTerm> speed = {};
  std::optional<SensorTerm> sensors = {};
  std::vector<Constraint> constraints;

  bool empty() const { return !path && !goal && !speed && !sensors && constraints.empty(); }
  /// What is wrong with their form, if anything: the field and the reason.
  std::optional<std::pair<std::string, std::string>> FirstProblem() const;
};

/// What became of a term on the finished clip.
struct ControlOutcome {
  std::string pointer;         // into the request: "/path", "/constraints/2"
  std::optional<int> index = {};    // of `constraints`, where it is one of them
  bool met = false;
  double residual = 0;
  double tolerance = 0;        // infinite where anything will do
  std::string unit = {};       // "m", "rad", "m/s", "m/s2" or "s", of both
  bool is_mean = false;        // of many frames, or a quantile over them
  std::vector<double> reached = {};  // what came nearest, in the form of the value that was asked for (degrees as radians); empty for areas and lines
};

}  // namespace morphograph
