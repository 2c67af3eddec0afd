#include "synthesis/control/walk_terms.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/forward_kinematics.h"
#include "datasets/leg_ik.h"
#include "primitives/whitening.h"
#include "synthesis/control/floor_area.h"
#include "synthesis/control/foot_landings.h"
#include "synthesis/control/residuals/reach_residual.h"
#include "synthesis/control/residuals/sensor_residual.h"
#include "synthesis/control/residuals/swing_residual.h"
#include "synthesis/control/residuals/tempo_residual.h"
#include "synthesis/foot_lock.h"
#include "synthesis/step_track.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();
constexpr double kTight = 0.1;  // part of its tolerance that a term may deviate by; less tightly where it is held over many frames
constexpr double kArrival_s = 0.01;
constexpr double kLoosePoint_m = 0.05, kLooseLook_rad = 0.35;  // deviations of what arms and head finish
constexpr double kReachSpare_m = 0.02;   // past what an arm did not reach
constexpr bool kAllAxes[3] = {true, true, true};
constexpr double kMostWork = 250'000;  // units of SteerBudget that one look at all terms may take, some seconds
constexpr double kSensor = 4;            // more of these, for each sensor on a pose
constexpr double kWholePose = 12;        // units of SteerBudget: a term that needs a joint of a whole pose
constexpr double kLegWork = 0.5, kTempoWork = 0.2;  // the same: a leg at a phase; how a step keeps time
constexpr int kReachSamples = 3;         // of a step's phases, so many apart, legs are looked at
constexpr double kReachMissing_m = 0.003;  // deviation of what a leg does not reach; captured feet stand within some 4 mm
constexpr double kReachHold = 0.5;       // sum over heel and ball, from which a foot counts as planted there
constexpr double kRootMargin_m = 0.02;
constexpr double kFootMargin_m = 0.08;   // between areas kept out of and the joints of the feet: heels and toes stand out
constexpr double kAreaReach_m = 1.2;     // of steps from the areas that concern them

}  // namespace

WalkTerms::WalkTerms(WalkState* walk, const TermSternness& sternness, ceres::Problem* equations)
    : walk_(*walk), problem_(walk->problem), sternness_(sternness), equations_(equations), directions_(walk->steps.size()) {}

void WalkTerms::AddAll() {
  AddPathAndGoal();
  AddConstraints();
  AddSensors();
  AddSwings();
  AddReach();
}

// A term of one step. What it says of the step's latent is one of the directions in which that one may move.
void WalkTerms::Add(StepResidual* residual, size_t step, double work) {
  work_ += work;
  ceres::LossFunction* scale = weight_ == 1 ? nullptr : new ceres::ScaledLoss(nullptr, weight_, ceres::TAKE_OWNERSHIP);
  equations_->AddResidualBlock(residual, scale, walk_.latents[step].data(), walk_.places[step].data());
  if (work_ > kMostWork) throw UnsatisfiableRequest("/constraints", "all that is asked for takes too much work at a time; ask for fewer terms or areas, for shorter times, or a shorter way");
  const Eigen::MatrixXd& rows = residual->ByLatent(walk_.latents[step], walk_.places[step]);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) directions_[step].push_back(rows.row(r));
}

Eigen::Vector3d* WalkTerms::NewOffset() { return &offsets_.emplace_back(Eigen::Vector3d::Zero()); }

void WalkTerms::AddRoot(const Moment& at, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation) {
  Eigen::Vector3d* offset = NewOffset();
  if (walk_.has_clip()) {
    const Eigen::Vector3d model = walk_.kinematics[at.step]->Root(at.moment, walk_.latents[at.step], walk_.places[at.step]).value;
    *offset = walk_.MeasuredRoot(at.frame) - model;
    (*offset)[2] = std::remainder((*offset)[2], 2 * M_PI);
  }
  Add(new RootResidual(walk_.kinematics[at.step], at.moment, target, deviation, offset), at.step);
}

void WalkTerms::AddJoint(const Moment& at, const ResolvedJoint& joint, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation,
                         const std::optional<Eigen::Vector3d>& measured) {
  Eigen::Vector3d* offset = NewOffset();
  if (measured) *offset = *measured - walk_.kinematics[at.step]->Joint(*joint.chain, at.moment, walk_.latents[at.step], walk_.places[at.step]).position_m;
  Add(new JointPositionResidual(walk_.kinematics[at.step], joint.chain, at.moment, target, deviation, offset), at.step, kWholePose);
}

void WalkTerms::AddPathAndGoal() {
  const ControlTerms& control = problem_.request.control;
  const double end = walk_.EndTime();
  if (control.path) {
    weight_ = control.path->weight;
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      for (const double phase : {0.0, 0.5}) {
        if (walk_.places[k][kPlaceTime] + phase * (walk_.places[k + 1][kPlaceTime] - walk_.places[k][kPlaceTime]) > end) continue;
        Add(new PathResidual(walk_.kinematics[k], {false, phase}, *problem_.guide.path, walk_.along_m[k] - 0.5, walk_.along_m[k + 1] + 0.5, sternness_.mean_part * control.path->tolerance_m), k);
      }
    }
  }
  if (problem_.goal_m) {
    Moment at = walk_.MomentOfTime(end);
    if (const auto keyframe = walk_.LastKeyframe()) at = {*keyframe - 1, {false, 1}, walk_.frames - 1};
    weight_ = control.goal ? control.goal->weight : control.path->weight;
    const double tolerance = control.goal ? control.goal->tolerance_m : control.path->tolerance_m;
    Eigen::Vector3d deviation(kTight * tolerance, kTight * tolerance, kFree);
    double heading = 0;
    if (control.goal && control.goal->heading_rad) {
      heading = *control.goal->heading_rad;
      deviation[2] = kTight * control.goal->heading_tolerance_rad;
    }
    AddRoot(at, {problem_.goal_m->x(), problem_.goal_m->y(), heading}, deviation);
  }
  if (walk_.stops() && problem_.guide.duration_s) {
    // Where a walk stops, its last step's margin is the end.
    const StepShape shape = problem_.graph.primitive(walk_.steps.back().primitive).Shape(walk_.steps.back().latent);
    const double margin = walk_.has_clip() ? (walk_.frames - 1) / walk_.rate() - walk_.places.back()[kPlaceTime] : MarginAfter(shape) * shape.duration_s;
    equations_->AddResidualBlock(new ArrivalResidual(*problem_.guide.duration_s - margin, kArrival_s), nullptr, walk_.places.back().data());
  }
  if (control.speed) {
    weight_ = control.speed->weight;
    for (size_t k = 0; k < walk_.steps.size() && walk_.places[k + 1][kPlaceTime] <= end + 1e-9; ++k) {
      const double middle = (walk_.places[k][kPlaceTime] + walk_.places[k + 1][kPlaceTime]) / 2;
      Add(new SpeedResidual(walk_.kinematics[k], SpeedAt(control.speed->profile, middle), sternness_.mean_part * control.speed->tolerance_m_s), k);
    }
  }
}

// Readings, by the steps in whose time they lie.
void WalkTerms::AddSensors() {
  if (!problem_.sensors) return;
  weight_ = problem_.request.control.sensors->weight;
  const auto last = std::min<Eigen::Index>(walk_.readings.cols() - 2, static_cast<Eigen::Index>(walk_.EndTime() * kSensorRate_hz) - 1);
  Eigen::Index from = 1;
  for (size_t k = 0; k < walk_.steps.size() && from <= last; ++k) {
    Eigen::Index to = from;
    while (to <= last && (static_cast<double>(to) / kSensorRate_hz < walk_.places[k + 1][kPlaceTime] || k + 1 == walk_.steps.size())) ++to;
    if (to == from) continue;
    Add(new SensorResidual(walk_.kinematics[k], problem_.chained_sensors, static_cast<double>(from) / kSensorRate_hz, kSensorRate_hz,
                           walk_.readings.middleCols(from, to - from), kReadingDeviation_m_s2),
        k, static_cast<double>(to - from) * (kWholePose + kSensor * static_cast<double>(problem_.chained_sensors.size())));
    from = to;
  }
}

// Steps keep time as captured ones do; and swings that no walker would make, once there was one.
void WalkTerms::AddSwings() {
  weight_ = 1;
  for (size_t k = 0; k < walk_.steps.size(); ++k) Add(new TempoResidual(walk_.kinematics[k]), k, kTempoWork);
  for (size_t k = 0; k < walk_.steps.size(); ++k) {
    if (!walk_.swings[k]) continue;
    const ResolvedJoint& ball = problem_.ball[LandingFoot(problem_.graph.primitive(walk_.steps[k].primitive))];
    Add(new SwingResidual(walk_.kinematics[k], ball.chain, *walk_.swings[k]), k, (kSwingSpans + 1) * kWholePose);
  }
}

// Planted feet, where the foot lock would not get them down by the legs alone: as it is told to do, from the learned contacts of each step.
void WalkTerms::AddReach() {
  weight_ = 1;
  const FootLockOptions lock;
  const FeetGeometry& feet = problem_.graph.styles()[static_cast<size_t>(problem_.style)].feet;
  const double leg_m[2] = {LegIk(problem_.graph.skeleton(), Foot::kLeft).length_m(), LegIk(problem_.graph.skeleton(), Foot::kRight).length_m()};
  for (size_t k = 0; k < walk_.steps.size(); ++k) {
    const MotionPrimitive& primitive = problem_.graph.primitive(walk_.steps[k].primitive);
    const ContactProfile contacts = primitive.Contacts(Colour(primitive.mixture.Component(walk_.steps[k].component), walk_.latents[k]));
    std::vector<PlantedMoment> moments;
    for (int sample = 0; sample < kPhaseSamples && PhaseOfSample(sample) < 1; ++sample) {
      if (PhaseOfSample(sample) < 0 || sample % kReachSamples != 1) continue;
      for (int side = 0; side < 2; ++side) {
        PlantedMoment moment{problem_.hip[side].chain, problem_.heel[side].chain, problem_.ball[side].chain, feet.heel_offset_m[side], leg_m[side], PhaseOfSample(sample)};
        for (int part = 0; part < 2; ++part) {
          const int row = 2 * side + part;
          const double sure = std::clamp((contacts(kPlantedChance + row, sample) - lock.loose_chance) / (1 - lock.loose_chance), 0.0, 1.0);
          const double standing = part == 0 ? feet.heel_height_m[side] : feet.ball_height_m[side];
          moment.hold[part] = sure * sure * (3 - 2 * sure);
          moment.height_m[part] = HeldHeight_m(standing, contacts(kPlantedHeight + row, sample), lock);
        }
        if (moment.hold[0] + moment.hold[1] > kReachHold) moments.push_back(std::move(moment));
      }
    }
    const double work = kLegWork * static_cast<double>(moments.size());
    if (!moments.empty()) Add(new ReachResidual(walk_.kinematics[k], std::move(moments), kReachMissing_m), k, work);
  }
}

void WalkTerms::AddConstraints() {
  const auto& constraints = problem_.request.control.constraints;
  for (size_t i = 0; i < constraints.size(); ++i) {
    std::visit(
        [&](const auto& term) {
          weight_ = term.weight;
          AddTerm(term, problem_.joints[i]);
        },
        constraints[i]);
  }
}

// A joint at a point. Arms and head finish by themselves what the walk brings near (see ApplyPoseGoals); where they did not reach, the walk
// has to bring the joint nearer that they hang from.
void WalkTerms::AddPoint(const Moment& at, const ResolvedJoint& joint, const Eigen::Vector3d& target, const bool* use, double tolerance_m) {
  Eigen::Vector3d deviation = Eigen::Vector3d::Constant(joint.finishes ? std::max(kLoosePoint_m, kTight * tolerance_m) : kTight * tolerance_m);
  const auto measured = walk_.MeasuredJoint(at.frame, joint.joint);
  if (joint.finishes && measured) {
    Eigen::Vector3d missing = target - *measured;
    for (int axis = 0; axis < 3; ++axis) missing[axis] *= use[axis];
    if (missing.norm() > kEnough * tolerance_m) {
      const Eigen::Vector3d base = *walk_.MeasuredJoint(at.frame, joint.base);
      const ResolvedJoint limb{joint.base, joint.base_chain};
      Eigen::Vector3d near = Eigen::Vector3d::Constant(kTight * kLoosePoint_m);
      for (int axis = 0; axis < 3; ++axis) {
        if (!use[axis]) near[axis] = kFree;
      }
      return AddJoint(at, limb, base + missing + kReachSpare_m * missing.normalized(), near, base);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!use[axis]) deviation[axis] = kFree;
  }
  AddJoint(at, joint, target, deviation, measured);
}

void WalkTerms::AddTerm(const PositionTerm& term, const std::vector<ResolvedJoint>& joints) {
  AddPoint(walk_.MomentOf(term.at), joints[0], term.value_m, term.use, term.tolerance_m);
}

void WalkTerms::AddTerm(const OrientationTerm& term, const std::vector<ResolvedJoint>& joints) {
  const Moment at = walk_.MomentOf(term.at);
  Add(new JointOrientationResidual(walk_.kinematics[at.step], joints[0].chain, at.moment, term.value, kTight * term.tolerance_rad), at.step, kWholePose);
}

void WalkTerms::AddTerm(const TrajectoryTerm& term, const std::vector<ResolvedJoint>& joints) {
  for (size_t k = 0; k < term.times_s.size(); ++k) {
    AddPoint(walk_.MomentOfTime(term.times_s[k]), joints[0], term.points_m[k], kAllAxes, term.tolerance_m);
  }
}

void WalkTerms::AddTerm(const HeadingTerm& term, const std::vector<ResolvedJoint>&) {
  AddRoot(walk_.MomentOf(term.at), {0, 0, term.value_rad}, {kFree, kFree, kTight * term.tolerance_rad});
}

void WalkTerms::AddTerm(const FootstepTerm& term, const std::vector<ResolvedJoint>&) {
  if (!walk_.has_clip()) return;  // which step it is, only a clip can say
  const PlantedFoot* foot = FootstepOf(term, walk_.made.evaluation.contacts);
  if (!foot) return;
  const int side = term.left ? 0 : 1;
  const double time = (foot->interval.first + foot->interval.last) / 2.0 / walk_.rate();
  const size_t step = walk_.StepAt(time);
  const double length = walk_.places[step + 1][kPlaceTime] - walk_.places[step][kPlaceTime];
  const double phase = std::clamp((time - walk_.places[step][kPlaceTime]) / length, 0.0, 1.0);
  const Moment at{step, {false, phase}, static_cast<int>(std::lround(time * walk_.rate()))};
  const double deviation = kTight * term.tolerance_m;
  AddJoint(at, problem_.ball[side], {term.value_m.x(), 0, term.value_m.y()}, {deviation, kFree, deviation},
           Eigen::Vector3d(foot->position_m.x(), 0, foot->position_m.y()));
}

void WalkTerms::AddTerm(const KeepOutTerm& term, const std::vector<ResolvedJoint>&) {
  const FloorArea area(term);
  for (size_t k = 0; k < walk_.steps.size() && walk_.places[k][kPlaceTime] <= walk_.EndTime(); ++k) {
    if (area.Depth(walk_.places[k].head<2>()) < -kAreaReach_m && area.Depth(walk_.places[k + 1].head<2>()) < -kAreaReach_m) continue;
    for (const double phase : {0.0, 0.25, 0.5, 0.75}) {
      const auto add = [&](const ResolvedJoint* joint, double margin_m) {
        Add(new KeepOutResidual(walk_.kinematics[k], joint ? joint->chain : nullptr, {false, phase}, term, margin_m, 0.005), k, joint ? kWholePose : 1);
      };
      add(nullptr, kRootMargin_m);
      for (int side = 0; side < 2; ++side) {
        add(&problem_.ball[side], std::max(kFootMargin_m, problem_.toes_m[side].norm() + kRootMargin_m));
        add(&problem_.heel[side], kFootMargin_m);
      }
    }
  }
}

void WalkTerms::AddTerm(const LookAtTerm& term, const std::vector<ResolvedJoint>&) {
  const double spacing = 0.15;
  const int count = std::max(1, static_cast<int>(std::ceil((term.to_s - term.from_s) / spacing)));
  for (int i = 0; i <= count; ++i) {
    const Moment at = walk_.MomentOfTime(term.from_s + (term.to_s - term.from_s) * i / count);
    Add(new LookAtResidual(walk_.kinematics[at.step], problem_.head.chain, at.moment, problem_.head_forward, term.value_m, std::max(sternness_.loose_part * kLooseLook_rad, sternness_.mean_part * term.tolerance_rad)), at.step, kWholePose);
  }
}

void WalkTerms::AddTerm(const PoseTerm& term, const std::vector<ResolvedJoint>& joints) {
  const Moment at = walk_.MomentOf(term.at);
  const FloorState root = walk_.kinematics[at.step]->Root(at.moment, walk_.latents[at.step], walk_.places[at.step]);
  const Eigen::AngleAxisd turn(root.value[2], Eigen::Vector3d::UnitY());
  for (size_t k = 0; k < joints.size(); ++k) {
    const Eigen::Vector3d target = turn * term.values_m[k] + Eigen::Vector3d(root.value[0], 0, root.value[1]);
    AddPoint(at, joints[k], target, kAllAxes, term.tolerance_m);
  }
}

}  // namespace morphograph
