#include "synthesis/control/control_problem.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "synthesis/control/floor_area.h"
#include "synthesis/control/pose_layer.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

constexpr double kGuideDeviation_m = 0.3;   // of a walk that only has to come to a goal
constexpr double kShortestGuide_m = 0.3;
constexpr double kReach_m = 0.45;          // of hands from the root, on the floor
constexpr double kPlaceSpacing_s = 0.2;    // between points of a line in space that the search looks at
// What one clip may ask for in all; more would take minutes.
constexpr double kMostPoses = 20'000;       // of arms and head: a look for a minute at 30 frames a second is 1,800
constexpr double kShortestToes_m = 0.01, kToes = 0.5;  // toes, in the length of a foot from ankle to ball
constexpr double kDetour_m = 0.5;           // of a guide's line around areas kept out of

std::string JointNames(const Skeleton& skeleton) {
  std::string names;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    if (skeleton.IsBody(j)) names += (names.empty() ? "" : ", ") + skeleton.joint(j).name;
  }
  return names;
}

class Maker {
 public:
  explicit Maker(ControlProblem* problem) : problem_(*problem), skeleton_(problem->graph.skeleton()) {}

  void Make() {
    ResolveJoints();
    ResolveSensors();
    MakeGuide();
  }

 private:
  ResolvedJoint Resolve(int joint) {
    const auto& means = problem_.graph.styles()[static_cast<size_t>(problem_.style)].mean_rotations;
    ResolvedJoint resolved{joint, std::make_shared<JointChain>(problem_.graph.layout(), means, joint)};
    const LimbChain limb(skeleton_, joint);
    if (!limb.empty()) {
      resolved.finishes = true;
      resolved.base = limb.base();
      resolved.base_chain = std::make_shared<JointChain>(problem_.graph.layout(), means, resolved.base);
    }
    return resolved;
  }

  ResolvedJoint Named(const std::string& name, const std::string& pointer) {
    const int joint = skeleton_.FindRoleOrName(name);
    if (joint < 0 || !skeleton_.IsBody(joint))
      throw UnsatisfiableRequest(pointer, "the model's skeleton has no joint '" + name + "'; it has the roles that CONTRACT names and the joints " + JointNames(skeleton_));
    return Resolve(joint);
  }

  void ResolveJoints() {
    const RoleMap& roles = skeleton_.roles();
    problem_.hip[0] = Resolve(roles[JointRole::kLeftHip]);
    problem_.hip[1] = Resolve(roles[JointRole::kRightHip]);
    problem_.ball[0] = Resolve(roles[JointRole::kLeftToe]);
    problem_.ball[1] = Resolve(roles[JointRole::kRightToe]);
    problem_.heel[0] = Resolve(roles[JointRole::kLeftAnkle]);
    problem_.heel[1] = Resolve(roles[JointRole::kRightAnkle]);
    for (int side = 0; side < 2; ++side) problem_.toes_m[side] = ToesOf(problem_.ball[side], problem_.heel[side]);
    if (roles.Has(JointRole::kHead)) {
      problem_.head = Resolve(roles[JointRole::kHead]);
      // On the whole a walker looks ahead: that direction, in the head of the style's mean pose.
      const Eigen::VectorXd mean = Eigen::VectorXd::Zero(problem_.graph.layout().channels());
      const double heading = problem_.graph.layout().HeadingOf(problem_.mean_root());
      problem_.head_forward = problem_.head.chain->At(mean).rotation.transpose() * Eigen::Vector3d(std::sin(heading), 0, std::cos(heading));
    }
    const auto& constraints = problem_.request.control.constraints;
    problem_.joints.resize(constraints.size());
    for (size_t i = 0; i < constraints.size(); ++i) {
      const std::string pointer = "/constraints/" + std::to_string(i);
      std::visit(
          [&](const auto& term) {
            using Term = std::decay_t<decltype(term)>;
            if constexpr (std::is_same_v<Term, PositionTerm> || std::is_same_v<Term, OrientationTerm> || std::is_same_v<Term, TrajectoryTerm>) {
              problem_.joints[i].push_back(Named(term.joint, pointer + "/joint"));
            } else if constexpr (std::is_same_v<Term, PoseTerm>) {
              for (const std::string& name : term.joints) problem_.joints[i].push_back(Named(name, pointer + "/joints"));
            } else if constexpr (std::is_same_v<Term, LookAtTerm>) {
              if (problem_.head.joint < 0) throw UnsatisfiableRequest(pointer, "the model's skeleton has no head");
            }
          },
          constraints[i]);
    }
  }

  // The tip of the toes: as the skeleton has it, or else as far before the ball as feet have it, in the style's mean pose.
  Eigen::Vector3d ToesOf(const ResolvedJoint& ball, const ResolvedJoint& ankle) const {
    if (const auto& end = skeleton_.joint(ball.joint).end_site_m; end && end->norm() > kShortestToes_m) return *end;
    const Eigen::VectorXd mean = Eigen::VectorXd::Zero(problem_.graph.layout().channels());
    const JointState at_ball = ball.chain->At(mean), at_ankle = ankle.chain->At(mean);
    Eigen::Vector3d foot = at_ball.position_m - at_ankle.position_m;
    foot.y() = 0;
    return at_ball.rotation.transpose() * (kToes * foot);
  }

  void ResolveSensors() {
    const auto& term = problem_.request.control.sensors;
    if (!term) return;
    problem_.sensors = term->guide;  // Synthesize() has made it
    const auto& means = problem_.graph.styles()[static_cast<size_t>(problem_.style)].mean_rotations;
    const std::vector<int> joints = JointsOf(problem_.sensors->placements, skeleton_);
    for (size_t s = 0; s < joints.size(); ++s) {
      problem_.chained_sensors.push_back({problem_.sensors->placements[s], std::make_shared<JointChain>(problem_.graph.layout(), means, joints[s])});
    }
  }

  // A line from start to goal: straight where their headings are free, else bent to them.
  std::vector<Eigen::Vector2d> GuideLine(const Eigen::Vector2d& goal, const std::optional<double>& goal_heading) const {
    const Eigen::Vector2d start = problem_.request.start.position_m;
    const double distance = (goal - start).norm();
    const Eigen::Vector2d straight = (goal - start) / distance;
    const Eigen::Vector2d leave = DirectionOfHeading(problem_.guide.start.heading_rad);
    const Eigen::Vector2d arrive = goal_heading ? DirectionOfHeading(*goal_heading) : straight;
    const double pull = std::max(distance, 1.5);  // a turn takes room, however near the goal is
    std::vector<Eigen::Vector2d> line;
    constexpr int kPieces = 60;
    for (int i = 0; i <= kPieces; ++i) {
      const double t = i / double{kPieces}, t2 = t * t, t3 = t2 * t;
      line.push_back((2 * t3 - 3 * t2 + 1) * start + (t3 - 2 * t2 + t) * pull * leave + (3 * t2 - 2 * t3) * goal + (t3 - t2) * pull * arrive);
    }
    AvoidAreas(&line);
    return line;
  }

  // Pushes a line out of areas, and smooths what that bends, back and forth.
  void AvoidAreas(std::vector<Eigen::Vector2d>* line) const {
    if (problem_.guide.keep_out.empty()) return;
    for (int round = 0; round < 200; ++round) {
      double worst = 0;
      for (size_t i = 1; i + 1 < line->size(); ++i) {
        Eigen::Vector2d& point = (*line)[i];
        point = 0.5 * point + 0.25 * ((*line)[i - 1] + (*line)[i + 1]);
        for (const FloorArea& area : problem_.guide.keep_out) {
          Eigen::RowVector2d gradient;
          const double depth = area.Depth(point, &gradient) + kDetour_m;
          if (depth > 0) point -= depth * gradient.transpose();
          worst = std::max(worst, depth);
        }
      }
      if (worst < 1e-3) return;
    }
  }

  void MakeGuide() {
    const SynthesisRequest& request = problem_.request;
    const ControlTerms& control = request.control;
    WalkGuide& guide = problem_.guide;
    guide.style = problem_.style;
    guide.from = request.start_from;
    guide.to = request.end;
    guide.frame_rate_hz = problem_.frame_rate_hz;
    guide.start = request.start;
    guide.duration_s = request.duration_s;
    guide.steps = request.steps;
    if (control.speed) guide.speeds = control.speed->profile;
    for (const Constraint& constraint : control.constraints) {
      if (const auto* area = std::get_if<KeepOutTerm>(&constraint)) guide.keep_out.emplace_back(*area);
      if (const auto* heading = std::get_if<HeadingTerm>(&constraint); heading && heading->at.time_s) guide.headings.push_back({*heading->at.time_s, heading->value_rad});
      if (const auto* foot = std::get_if<FootstepTerm>(&constraint)) guide.feet.push_back({foot->left, foot->index, foot->value_m});
      if (const auto* position = std::get_if<PositionTerm>(&constraint); position && position->at.time_s && position->use[0] && position->use[2])
        guide.places.push_back({*position->at.time_s, {position->value_m.x(), position->value_m.z()}, kReach_m});
      if (const auto* trajectory = std::get_if<TrajectoryTerm>(&constraint)) {
        double last = -1;
        for (size_t k = 0; k < trajectory->times_s.size(); ++k) {
          if (trajectory->times_s[k] < last + kPlaceSpacing_s) continue;
          last = trajectory->times_s[k];
          guide.places.push_back({trajectory->times_s[k], {trajectory->points_m[k].x(), trajectory->points_m[k].z()}, kReach_m});
        }
      }
    }
    if (control.path) {
      guide.path.emplace(control.path->points_m, control.path->smooth);
      if (!request.start_given.position) guide.start.position_m = guide.path->At(0);
      problem_.goal_m = guide.path->At(guide.path->length_m());
    }
    if (control.goal) {
      problem_.goal_m = control.goal->position_m;
      guide.goal_heading_rad = control.goal->heading_rad;
      if (control.goal->time_s) guide.duration_s = control.goal->time_s;
    }
    guide.goal_m = problem_.goal_m;
    // A heading that was not asked for is the way's; inside a walk it may give a little.
    const bool heads_along = problem_.goal_m && !request.start_given.heading;
    guide.free_heading = heads_along && guide.from == WalkBoundary::kWalking;
    if (control.goal && !control.path) {
      if ((control.goal->position_m - guide.start.position_m).norm() < kShortestGuide_m)
        throw UnsatisfiableRequest("/goal/position", "must be at least 0.3 m from the start");
      if (heads_along) {
        const Eigen::Vector2d ahead = control.goal->position_m - guide.start.position_m;
        guide.start.heading_rad = HeadingOfDirection(ahead);
      }
      guide.path.emplace(GuideLine(control.goal->position_m, control.goal->heading_rad));
      guide.path_deviation_m = kGuideDeviation_m;
    } else if (heads_along) {
      guide.start.heading_rad = guide.path->Heading(0);
    }
    if (problem_.sensors) {
      for (const DrawnStep& step : problem_.sensors->walk.steps) guide.given.push_back(step.step);
      if (!guide.given.empty()) {
        // On the graph a step may take less time than was found. Its end lies among the readings, its beginning only may.
        const DrawnStep& first = problem_.sensors->walk.steps.front();
        const double duration_s = problem_.graph.primitive(first.step.primitive).Shape(first.step.latent).duration_s;
        guide.given_from_s = std::min(0.0, first.end / kSensorRate_hz - duration_s);
      }
      if (!guide.duration_s && !guide.steps && problem_.sensors->readings.cols() >= 2) guide.duration_s = problem_.sensors->duration_s();
    }
    if (!guide.duration_s && !guide.steps && !guide.path) guide.duration_s = kDefaultDuration_s;
    CheckAreas();
    CheckAmount();
  }

  // @throws UnsatisfiableRequest where the constraints ask for more than one clip may.
  void CheckAmount() const {
    double poses = 0;
    const auto span = [&](double from_s, double to_s) { poses += 1 + std::max(0.0, std::min(to_s, kMaxDuration_s) - from_s) * problem_.frame_rate_hz; };
    for (const Constraint& constraint : problem_.request.control.constraints) {
      if (const auto* look = std::get_if<LookAtTerm>(&constraint)) span(look->from_s, look->to_s);
      if (const auto* trajectory = std::get_if<TrajectoryTerm>(&constraint); trajectory && !trajectory->times_s.empty()) span(trajectory->times_s.front(), trajectory->times_s.back());
      if (const auto* pose = std::get_if<PoseTerm>(&constraint)) poses += static_cast<double>(pose->joints.size());
    }
    if (poses <= kMostPoses) return;
    throw UnsatisfiableRequest("/constraints", "ask for " + std::to_string(static_cast<long>(poses)) + " poses of arms and head, one a frame; one clip may ask for " +
                                                   std::to_string(static_cast<long>(kMostPoses)) + ": ask for shorter spans, or for fewer frames a second");
  }

  // Areas that hold the start, the goal or a part of the path cannot be kept out of.
  void CheckAreas() const {
    const auto& constraints = problem_.request.control.constraints;
    for (size_t i = 0; i < constraints.size(); ++i) {
      const auto* area = std::get_if<KeepOutTerm>(&constraints[i]);
      if (!area) continue;
      const FloorArea floor_area(*area);
      const auto check = [&](const Eigen::Vector2d& point, const std::string& what) {
        if (const double depth = floor_area.Depth(point); depth > 0)
          throw UnsatisfiableRequest("/constraints/" + std::to_string(i), what + std::to_string(depth) + " m inside");
      };
      check(problem_.guide.start.position_m, "the start lies ");
      if (problem_.goal_m) check(*problem_.goal_m, "the goal lies ");
      if (problem_.request.control.path) {
        for (double along = 0; along < problem_.guide.path->length_m(); along += 0.05) check(problem_.guide.path->At(along), "the path leads ");
      }
    }
  }

  ControlProblem& problem_;
  const Skeleton& skeleton_;
};

}  // namespace

ControlProblem MakeControlProblem(const MotionGraph& graph, const SynthesisRequest& request, int style, double frame_rate_hz) {
  if (graph.layout().rotation_form() != RotationForm::kLogMap)
    throw UnsatisfiableRequest("/model", "its poses are Euler angles, which cannot be steered");
  ControlProblem problem{.graph = graph, .request = request, .style = style, .frame_rate_hz = frame_rate_hz};
  Maker(&problem).Make();
  return problem;
}

}  // namespace morphograph
