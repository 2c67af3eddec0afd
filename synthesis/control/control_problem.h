#pragma once

#include <memory>
#include <vector>

#include "synthesis/control/chained_sensor.h"
#include "synthesis/control/sensor_guide.h"
#include "synthesis/control/walk_planner.h"

namespace morphograph {

/// A term on a joint, resolved against the skeleton.
struct ResolvedJoint {
  int joint = -1;
  std::shared_ptr<const JointChain> chain;
  bool finishes = false;  // a joint of an arm or the head: a pose goal takes it to its place
  int base = -1;          // of these, the joint that the limb hangs from: what the walk has to bring near
  std::shared_ptr<const JointChain> base_chain = {};
};

/// A request with control terms, made ready for one style of a graph: joints found, angles and times in place, a line to be guided by.
struct ControlProblem {
  const MotionGraph& graph;
  const SynthesisRequest& request;
  int style = 0;
  double frame_rate_hz = 30;
  WalkGuide guide = {};     // its path, where none was asked for, only leads to the goal
  std::optional<Eigen::Vector2d> goal_m = {};  // of the goal, else the end of the path that was asked for
  std::vector<std::vector<ResolvedJoint>> joints = {};  // per constraint
  Eigen::Vector3d head_forward = Eigen::Vector3d::UnitZ();  // in the head's frame
  std::shared_ptr<const SensorGuide> sensors = {};  // where readings were given
  std::vector<ChainedSensor> chained_sensors = {};  // of sensors->placements
  ResolvedJoint head = {}, hip[2] = {}, ball[2] = {}, heel[2] = {};  // hip, ball and ankle of the left and the right foot
  Eigen::Vector3d toes_m[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};  // from the ball of a foot to the tip of its toes, in the ball's frame

  const Eigen::Quaterniond& mean_root() const {
    return graph.styles()[static_cast<size_t>(style)].mean_rotations[static_cast<size_t>(graph.layout().active_joints()[0])];
  }
};

/// @throws UnsatisfiableRequest where the terms contradict each other or the skeleton, as far as can be told before anything is drawn.
ControlProblem MakeControlProblem(const MotionGraph& graph, const SynthesisRequest& request, int style, double frame_rate_hz);

}  // namespace morphograph
