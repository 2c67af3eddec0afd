#include "synthesis/control/walk_optimizer.h"

#include <Eigen/QR>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>
#include <list>

#include "synthesis/control/residuals/control_residuals.h"
#include "synthesis/control/residuals/sensor_residual.h"
#include "synthesis/control/floor_area.h"
#include "synthesis/control/pose_goals.h"
#include "synthesis/step_track.h"
#include "synthesis/walk_clip.h"

namespace morphograph {
namespace {

constexpr int kRounds = 4;
constexpr int kFirstIterations = 8, kLaterIterations = 4;
constexpr double kShortWalk = 20;  // steps; in longer ones what joins leave loose would add up
constexpr double kArrival_s = 0.01;
constexpr double kFree = std::numeric_limits<double>::infinity();
// Part of its tolerance that a term may deviate by; less tightly where it is held over many frames, by a body that sways.
constexpr double kTight = 0.1, kMean = 0.4, kSternest = 0.15;
// Parts of the tolerances within which nothing more is done; for means over a whole clip, which another round hardly changes, and the rest.
constexpr double kEnoughOnTheWhole = 0.9, kEnough = 0.5;
constexpr double kHelps = 0.5, kProgress = 0.95;        // of the largest residual, from round to round; more is none
constexpr double kLoosePoint_m = 0.05, kLooseLook_rad = 0.35;  // deviations of what arms and head finish
constexpr double kReachSpare_m = 0.02;     // past what an arm did not reach
constexpr bool kAllAxes[3] = {true, true, true};
// Norms of latents, in the largest of the training: how far outside of it they are likely to be moved, and how far at most.
constexpr double kRadius = 0.02, kFarthest = 0.15;
constexpr double kFootMargin_m = 0.08;   // between areas kept out of and the joints of the feet: heels and toes stand out
constexpr double kAreaReach_m = 1.2;     // of steps from the areas that concern them
constexpr double kFoundTime_s = 0.02;    // of the first key frame of steps that were found in readings
constexpr double kSensor_m_s2 = 1.5;     // of a reading about what a step says: noise, mounting, what the model does not hold (METHODS section 5)
constexpr double kFreeHeading_rad = 0.2; // deviation of a start whose heading was not asked for

Eigen::Vector3d Turned(double heading, const Eigen::Vector3d& local) {
  const double c = std::cos(heading), s = std::sin(heading);
  return {c * local[0] + s * local[1], -s * local[0] + c * local[1], local[2]};
}

// A latent that moves in a subspace only: x + basis d.
class Subspace : public ceres::Manifold {
 public:
  /// @param basis  (D x r), orthonormal columns.
  explicit Subspace(Eigen::MatrixXd basis) : basis_(std::move(basis)) {}
  int AmbientSize() const override { return static_cast<int>(basis_.rows()); }
  int TangentSize() const override { return static_cast<int>(basis_.cols()); }
  bool Plus(const double* x, const double* delta, double* sum) const override {
    Vector(sum, basis_.rows()) = ConstVector(x, basis_.rows()) + basis_ * ConstVector(delta, basis_.cols());
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    RowMajor(jacobian, basis_.rows(), basis_.cols()) = basis_;
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    Vector(delta, basis_.cols()) = basis_.transpose() * (ConstVector(y, basis_.rows()) - ConstVector(x, basis_.rows()));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    RowMajor(jacobian, basis_.cols(), basis_.rows()) = basis_.transpose();
    return true;
  }

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;
  using ConstVector = Eigen::Map<const Eigen::VectorXd>;
  using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  Eigen::MatrixXd basis_;
};

class Optimizer {
 public:
  Optimizer(const ControlProblem& problem, const WalkPlan& plan, KinematicsCache* kinematics, const PosteriorDraw& draw)
      : problem_(problem), graph_(problem.graph), steps_(plan.steps), along_m_(plan.along_m), frames_(plan.frames), places_(plan.places) {
    for (size_t k = 0; k < steps_.size(); ++k) {
      kinematics_.push_back(kinematics->Of(steps_[k]));
      latents_.push_back(steps_[k].whitened);
      if (k == 0) continue;
      innovations_.emplace_back(graph_, steps_[k - 1], steps_[k]);
      drawn_.push_back(innovations_.back().Value(latents_[k - 1], latents_[k]));
      covariances_.push_back(innovations_.back().Covariance());
    }
    first_ = latents_[0];
    if (!draw.innovations.empty()) {
      const WithinWalk within = WithinWalkOf(graph_, steps_[0]);
      first_ = within.manner + within.scale.cwiseProduct(draw.innovations[0]);
    }
    for (size_t k = 1; k < std::min(steps_.size(), draw.innovations.size()); ++k) drawn_[k - 1] = draw.innovations[k];
    if (problem_.sensors) {
      readings_ = problem_.sensors->readings;
      if (draw.readings_m_s2.size() > 0) readings_ += draw.readings_m_s2;
    }
    joins_.assign(steps_.size(), Eigen::Vector3d::Zero());
    result_.start = problem_.guide.start;
    result_.start.heading_rad = FirstHeading();
  }

  SteeredWalk Run() {
    SteeredWalk best;
    double least = kFree;
    const int rounds = kRounds + static_cast<int>(steps_.size()) / 40;
    for (int round = 0; round < rounds; ++round) {
      // Long walks bend farther before they are where they should be.
      Solve((round == 0 ? kFirstIterations : kLaterIterations) + static_cast<int>(steps_.size()) / 10);
      MakeClip();
      const double worst = WorstMiss(), before = least;
      if (round == 0 || Unmet(result_) < Unmet(best) || (Unmet(result_) == Unmet(best) && worst < least)) {
        least = worst;
        best = result_;
      }
      // While rounds still help by themselves, and in long walks at first, what is missing is only that clips are not what the steps alone say.
      const bool helps = round == 0 ? steps_.size() > 2 * kShortWalk : worst < kHelps * before;
      const bool tightened = !helps && Tighten();
      if (least <= 1 || (round > 0 && !helps && !tightened && worst > kProgress * before)) break;
      TakeOverPlaces();
    }
    return best;
  }

 private:
  double rate() const { return problem_.frame_rate_hz; }
  bool stops() const { return problem_.guide.to != WalkBoundary::kWalking; }
  // Whether the clip begins inside of its first step, not with it.
  bool begins_inside() const { return !problem_.guide.given.empty(); }
  double FirstHeading() const {
    return begins_inside() ? kinematics_[0]->Root({true, 0}, latents_[0], places_[0]).value[2] : places_[0][kPlaceHeading];
  }
  // The key frame that a clip ends at, or, where the walk stops, after; none where a time or a place on the path ends it.
  std::optional<size_t> LastKeyframe() const {
    if (stops()) return steps_.size();
    if (problem_.guide.steps) return std::min(steps_.size(), static_cast<size_t>(*problem_.guide.steps));
    return std::nullopt;
  }
  double EndTime() const { return LastKeyframe() ? places_[*LastKeyframe()][kPlaceTime] : (frames_ - 1) / rate(); }

  size_t StepAt(double time_s) const {
    size_t k = 0;
    while (k + 1 < steps_.size() && places_[k + 1][kPlaceTime] <= time_s) ++k;
    return k;
  }

  struct Place {
    size_t step;
    StepMoment moment;
    int frame;
  };
  Place PlaceOfTime(double time_s) const {
    const int frame = std::clamp(static_cast<int>(std::lround(time_s * rate())), 0, frames_ - 1);
    return {StepAt(frame / rate()), {true, frame / rate()}, frame};
  }
  Place PlaceOf(const ControlMoment& moment) const {
    if (moment.time_s) return PlaceOfTime(*moment.time_s);
    const auto keyframe = static_cast<size_t>(std::max(0, *moment.keyframe));
    const size_t step = std::min(keyframe, steps_.size() - 1);
    const double phase = keyframe > step ? 1 : 0;
    const double time = places_[std::min(keyframe, steps_.size())][kPlaceTime];
    return {step, {false, phase}, std::clamp(static_cast<int>(std::lround(time * rate())), 0, frames_ - 1)};
  }

  // A term of one step. What it says of the step's latent is one of the directions in which that one may move.
  void Add(ceres::Problem* problem, StepResidual* residual, size_t step) {
    problem->AddResidualBlock(residual, nullptr, latents_[step].data(), places_[step].data());
    const Eigen::MatrixXd rows = residual->ByLatent(latents_[step], places_[step]);
    for (Eigen::Index r = 0; r < rows.rows(); ++r) directions_[step].push_back(rows.row(r));
  }

  // Latents move in the directions that the terms and the way to the next key frame depend on, and in those that transitions carry over from
  // the ways of the neighbours. In whitened space, where the prior is the same all around, there is next to no reason for others, and the
  // equations become a tenth as large.
  void RestrictLatents(ceres::Problem* problem) {
    std::vector<Eigen::MatrixXd> ways;
    for (size_t k = 0; k < steps_.size(); ++k) ways.push_back(kinematics_[k]->Next(latents_[k], places_[k]).by_latent);
    for (size_t k = 0; k < steps_.size(); ++k) {
      auto& directions = directions_[k];
      const auto add = [&](const Eigen::MatrixXd& more) {
        for (Eigen::Index r = 0; r < more.rows(); ++r) directions.push_back(more.row(r));
      };
      add(ways[k]);
      if (k > 0) add(ways[k - 1] * covariances_[k - 1].transpose());
      if (k + 1 < steps_.size()) add(ways[k + 1] * covariances_[k]);
      Eigen::MatrixXd rows(static_cast<Eigen::Index>(directions.size()), latents_[k].size());
      for (size_t r = 0; r < directions.size(); ++r) rows.row(static_cast<Eigen::Index>(r)) = directions[r];
      for (Eigen::Index r = 0; r < rows.rows(); ++r) {
        if (const double norm = rows.row(r).norm(); norm > 1e-9) rows.row(r) /= norm;
      }
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows.transpose());
      qr.setThreshold(1e-4);
      const Eigen::Index rank = qr.rank();
      if (rank == 0 || rank == rows.cols()) continue;
      problem->SetManifold(latents_[k].data(), new Subspace(qr.householderQ() * Eigen::MatrixXd::Identity(rows.cols(), rank)));
    }
  }

  bool has_clip() const { return result_.clip.frame_count() > 0; }
  Eigen::Vector3d* NewOffset() { return &offsets_.emplace_back(Eigen::Vector3d::Zero()); }

  void AddRoot(ceres::Problem* problem, const Place& at, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation) {
    Eigen::Vector3d* offset = NewOffset();
    if (has_clip()) {
      const Eigen::Vector3d model = kinematics_[at.step]->Root(at.moment, latents_[at.step], places_[at.step]).value;
      *offset = MeasuredRoot(at.frame) - model;
      (*offset)[2] = std::remainder((*offset)[2], 2 * M_PI);
    }
    Add(problem, new RootResidual(kinematics_[at.step], at.moment, target, deviation, offset), at.step);
  }

  void AddJoint(ceres::Problem* problem, const Place& at, const ResolvedJoint& joint, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation,
                const std::optional<Eigen::Vector3d>& measured) {
    Eigen::Vector3d* offset = NewOffset();
    if (measured) *offset = *measured - kinematics_[at.step]->Joint(*joint.chain, at.moment, latents_[at.step], places_[at.step]).position_m;
    Add(problem, new JointPositionResidual(kinematics_[at.step], joint.chain, at.moment, target, deviation, offset), at.step);
  }

  std::optional<Eigen::Vector3d> MeasuredJoint(int frame, int joint) const {
    if (!has_clip()) return std::nullopt;
    return ForwardKinematics(result_.clip, frame).positions.col(joint);
  }

  Eigen::Vector3d MeasuredRoot(int frame) const {
    return {result_.clip.root_positions()(0, frame), result_.clip.root_positions()(2, frame), HeadingRad(result_.clip, frame)};
  }

  void AddPrior(ceres::Problem* problem) {
    problem->AddResidualBlock(new FirstStepResidual(first_, WithinWalkOf(graph_, steps_[0]).scale), nullptr, latents_[0].data());
    const double heading = problem_.guide.free_heading ? kFreeHeading_rad : 1e-4;
    problem->AddResidualBlock(new StartResidual(places_[0], {1e-4, 1e-4, heading, begins_inside() ? kFoundTime_s : 1e-4}), nullptr, places_[0].data());
    const double looseness = std::min(1.0, kShortWalk / static_cast<double>(steps_.size()));
    for (size_t k = 0; k < steps_.size(); ++k) {
      if (const double radius = graph_.primitive(steps_[k].primitive).latent_radius; radius > 0) {
        const int dimension = static_cast<int>(latents_[k].size());
        problem->AddResidualBlock(new RadiusResidual(dimension, std::max(radius, steps_[k].whitened.norm()), kRadius * radius), nullptr, latents_[k].data());
      }
      if (k > 0) problem->AddResidualBlock(new InnovationResidual(innovations_[k - 1], drawn_[k - 1]), nullptr, latents_[k - 1].data(), latents_[k].data());
      problem->AddResidualBlock(new NextPlaceResidual(kinematics_[k], &joins_[k], looseness), nullptr, latents_[k].data(), places_[k].data(), places_[k + 1].data());
    }
  }

  void AddPathAndGoal(ceres::Problem* problem) {
    const ControlTerms& control = problem_.request.control;
    const double end = EndTime();
    if (control.path) {
      for (size_t k = 0; k < steps_.size(); ++k) {
        for (const double phase : {0.0, 0.5}) {
          if (places_[k][kPlaceTime] + phase * (places_[k + 1][kPlaceTime] - places_[k][kPlaceTime]) > end) continue;
          Add(problem, new PathResidual(kinematics_[k], {false, phase}, *problem_.guide.path, along_m_[k] - 0.5, along_m_[k + 1] + 0.5, mean_part_ * control.path->tolerance_m), k);
        }
      }
    }
    if (problem_.goal_m) {
      Place at = PlaceOfTime(end);
      if (const auto keyframe = LastKeyframe()) at = {*keyframe - 1, {false, 1}, frames_ - 1};
      const double tolerance = control.goal ? control.goal->tolerance_m : control.path->tolerance_m;
      Eigen::Vector3d deviation(kTight * tolerance, kTight * tolerance, kFree);
      double heading = 0;
      if (control.goal && control.goal->heading_rad) {
        heading = *control.goal->heading_rad;
        deviation[2] = kTight * control.goal->heading_tolerance_rad;
      }
      AddRoot(problem, at, {problem_.goal_m->x(), problem_.goal_m->y(), heading}, deviation);
    }
    if (stops() && problem_.guide.duration_s) {
      // Where a walk stops, its last step's margin is the end.
      const StepShape shape = graph_.primitive(steps_.back().primitive).Shape(steps_.back().latent);
      const double margin = has_clip() ? (frames_ - 1) / rate() - places_.back()[kPlaceTime] : MarginAfter(shape) * shape.duration_s;
      problem->AddResidualBlock(new ArrivalResidual(*problem_.guide.duration_s - margin, kArrival_s), nullptr, places_.back().data());
    }
    if (control.speed) {
      for (size_t k = 0; k < steps_.size() && places_[k + 1][kPlaceTime] <= end + 1e-9; ++k) {
        const double middle = (places_[k][kPlaceTime] + places_[k + 1][kPlaceTime]) / 2;
        Add(problem, new SpeedResidual(kinematics_[k], SpeedAt(control.speed->profile, middle), mean_part_ * control.speed->tolerance_m_s), k);
      }
    }
  }

  // Readings, by the steps in whose time they lie.
  void AddSensors(ceres::Problem* problem) {
    if (!problem_.sensors) return;
    const auto last = std::min<Eigen::Index>(readings_.cols() - 2, static_cast<Eigen::Index>(EndTime() * kSensorRate_hz) - 1);
    Eigen::Index from = 1;
    for (size_t k = 0; k < steps_.size() && from <= last; ++k) {
      Eigen::Index to = from;
      while (to <= last && (static_cast<double>(to) / kSensorRate_hz < places_[k + 1][kPlaceTime] || k + 1 == steps_.size())) ++to;
      if (to == from) continue;
      Add(problem, new SensorResidual(kinematics_[k], problem_.chained_sensors, static_cast<double>(from) / kSensorRate_hz, kSensorRate_hz,
                                      readings_.middleCols(from, to - from), kSensor_m_s2), k);
      from = to;
    }
  }

  void AddConstraints(ceres::Problem* problem) {
    const auto& constraints = problem_.request.control.constraints;
    for (size_t i = 0; i < constraints.size(); ++i) {
      std::visit([&](const auto& term) { AddTerm(problem, term, problem_.joints[i]); }, constraints[i]);
    }
  }

  // A joint at a point. Arms and head finish by themselves what the walk brings near (see ApplyPoseGoals); where they did not reach, the walk
  // has to bring the joint nearer that they hang from.
  void AddPoint(ceres::Problem* problem, const Place& at, const ResolvedJoint& joint, const Eigen::Vector3d& target, const bool* use, double tolerance_m) {
    Eigen::Vector3d deviation = Eigen::Vector3d::Constant(joint.finishes ? std::max(kLoosePoint_m, kTight * tolerance_m) : kTight * tolerance_m);
    const auto measured = MeasuredJoint(at.frame, joint.joint);
    if (joint.finishes && measured) {
      Eigen::Vector3d missing = target - *measured;
      for (int axis = 0; axis < 3; ++axis) missing[axis] *= use[axis];
      if (missing.norm() > kEnough * tolerance_m) {
        const Eigen::Vector3d base = *MeasuredJoint(at.frame, joint.base);
        const ResolvedJoint limb{joint.base, joint.base_chain};
        Eigen::Vector3d near = Eigen::Vector3d::Constant(kTight * kLoosePoint_m);
        for (int axis = 0; axis < 3; ++axis) {
          if (!use[axis]) near[axis] = kFree;
        }
        return AddJoint(problem, at, limb, base + missing + kReachSpare_m * missing.normalized(), near, base);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (!use[axis]) deviation[axis] = kFree;
    }
    AddJoint(problem, at, joint, target, deviation, measured);
  }

  void AddTerm(ceres::Problem* problem, const PositionTerm& term, const std::vector<ResolvedJoint>& joints) {
    AddPoint(problem, PlaceOf(term.at), joints[0], term.value_m, term.use, term.tolerance_m);
  }

  void AddTerm(ceres::Problem* problem, const OrientationTerm& term, const std::vector<ResolvedJoint>& joints) {
    const Place at = PlaceOf(term.at);
    Add(problem, new JointOrientationResidual(kinematics_[at.step], joints[0].chain, at.moment, term.value, kTight * term.tolerance_rad), at.step);
  }

  void AddTerm(ceres::Problem* problem, const TrajectoryTerm& term, const std::vector<ResolvedJoint>& joints) {
    for (size_t k = 0; k < term.times_s.size(); ++k) {
      AddPoint(problem, PlaceOfTime(term.times_s[k]), joints[0], term.points_m[k], kAllAxes, term.tolerance_m);
    }
  }

  void AddTerm(ceres::Problem* problem, const HeadingTerm& term, const std::vector<ResolvedJoint>&) {
    AddRoot(problem, PlaceOf(term.at), {0, 0, term.value_rad}, {kFree, kFree, kTight * term.tolerance_rad});
  }

  void AddTerm(ceres::Problem* problem, const FootstepTerm& term, const std::vector<ResolvedJoint>&) {
    if (!has_clip()) return;  // which step it is, only a clip can say
    const PlantedFoot* foot = FootstepOf(term, result_.evaluation.contacts);
    if (!foot) return;
    const int side = term.left ? 0 : 1;
    const double time = (foot->interval.first + foot->interval.last) / 2.0 / rate();
    const size_t step = StepAt(time);
    const double length = places_[step + 1][kPlaceTime] - places_[step][kPlaceTime];
    const double phase = std::clamp((time - places_[step][kPlaceTime]) / length, 0.0, 1.0);
    const Place at{step, {false, phase}, static_cast<int>(std::lround(time * rate()))};
    const double deviation = kTight * term.tolerance_m;
    AddJoint(problem, at, problem_.ball[side], {term.value_m.x(), 0, term.value_m.y()}, {deviation, kFree, deviation},
             Eigen::Vector3d(foot->position_m.x(), 0, foot->position_m.y()));
  }

  void AddTerm(ceres::Problem* problem, const KeepOutTerm& term, const std::vector<ResolvedJoint>&) {
    const FloorArea area(term);
    for (size_t k = 0; k < steps_.size() && places_[k][kPlaceTime] <= EndTime(); ++k) {
      if (area.Depth(places_[k].head<2>()) < -kAreaReach_m && area.Depth(places_[k + 1].head<2>()) < -kAreaReach_m) continue;
      for (const double phase : {0.0, 0.25, 0.5, 0.75}) {
        const auto add = [&](const ResolvedJoint* joint) {
          Add(problem, new KeepOutResidual(kinematics_[k], joint ? joint->chain : nullptr, {false, phase}, term, joint ? kFootMargin_m : 0.02, 0.005), k);
        };
        add(nullptr);
        for (int side = 0; side < 2; ++side) {
          add(&problem_.ball[side]);
          add(&problem_.heel[side]);
        }
      }
    }
  }

  void AddTerm(ceres::Problem* problem, const LookAtTerm& term, const std::vector<ResolvedJoint>&) {
    const double spacing = 0.15;
    const int count = std::max(1, static_cast<int>(std::ceil((term.to_s - term.from_s) / spacing)));
    for (int i = 0; i <= count; ++i) {
      const Place at = PlaceOfTime(term.from_s + (term.to_s - term.from_s) * i / count);
      Add(problem, new LookAtResidual(kinematics_[at.step], problem_.head.chain, at.moment, problem_.head_forward, term.value_m, std::max(loose_part_ * kLooseLook_rad, mean_part_ * term.tolerance_rad)), at.step);
    }
  }

  void AddTerm(ceres::Problem* problem, const PoseTerm& term, const std::vector<ResolvedJoint>& joints) {
    const Place at = PlaceOf(term.at);
    const FloorState root = kinematics_[at.step]->Root(at.moment, latents_[at.step], places_[at.step]);
    const Eigen::AngleAxisd turn(root.value[2], Eigen::Vector3d::UnitY());
    for (size_t k = 0; k < joints.size(); ++k) {
      const Eigen::Vector3d target = turn * term.values_m[k] + Eigen::Vector3d(root.value[0], 0, root.value[1]);
      AddPoint(problem, at, joints[k], target, kAllAxes, term.tolerance_m);
    }
  }

  void Solve(int iterations) {
    offsets_.clear();
    directions_.assign(steps_.size(), {});
    ceres::Problem problem;
    AddPrior(&problem);
    AddPathAndGoal(&problem);
    AddConstraints(&problem);
    AddSensors(&problem);
    RestrictLatents(&problem);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = iterations;
    options.function_tolerance = 1e-3;
    options.trust_region_strategy_type = ceres::DOGLEG;  // shortens steps for which the places of key frames are too stiff
    options.initial_trust_region_radius = 300 * std::max(1.0, std::pow(static_cast<double>(steps_.size()) / kShortWalk, 1.5));
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    KeepBelievable();
  }

  // Steps that were moved farther out than anything captured go back towards the plan: a walk that would need them cannot be had.
  void KeepBelievable() {
    for (size_t k = 0; k < steps_.size(); ++k) {
      const double radius = graph_.primitive(steps_[k].primitive).latent_radius;
      const Eigen::VectorXd& planned = steps_[k].whitened;
      // Steps after a start lie far out as they are drawn.
      const double limit = std::max(radius, planned.norm()) + kFarthest * radius;
      if (!(radius > 0) || latents_[k].norm() <= limit) continue;
      // The point between plan and solution where the norm is at its limit.
      const Eigen::VectorXd moved = latents_[k] - planned;
      const double a = moved.squaredNorm(), b = planned.dot(moved), c = planned.squaredNorm() - limit * limit;
      const double part = std::clamp((-b + std::sqrt(std::max(0.0, b * b - a * c))) / a, 0.0, 1.0);
      latents_[k] = planned + part * moved;
    }
  }

  void MakeClip() {
    result_.walk.steps.clear();
    double time = 0;
    for (size_t k = 0; k < steps_.size(); ++k) {
      WalkStep step = steps_[k];
      MoveTo(graph_, latents_[k], &step);
      step.log_likelihood = k > 0 ? innovations_[k - 1].LogLikelihood(latents_[k - 1], latents_[k])
                                  : graph_.primitive(step.primitive).mixture.LogDensity(step.latent);
      StepShape shape = graph_.primitive(step.primitive).Shape(step.latent);
      const double length = shape.duration_s * rate();
      if (k == 0 && problem_.guide.from != WalkBoundary::kWalking) time = MarginBefore(shape) * length;
      if (k == 0 && begins_inside()) time = std::min(0.0, places_[0][kPlaceTime] * rate());
      result_.walk.steps.push_back({std::move(step), std::move(shape), time, time + length});
      time += length;
    }
    if (const auto keyframe = LastKeyframe()) {
      const DrawnStep& last = result_.walk.steps[*keyframe - 1];
      const double margin = stops() ? MarginAfter(last.shape) * (last.end - last.start) : 0;
      frames_ = std::max(2, static_cast<int>(std::floor(last.end + margin)) + 1);
    }
    result_.walk.frames = frames_;
    if (problem_.guide.free_heading) result_.start.heading_rad = FirstHeading();
    result_.clip = MakeWalkClip(graph_, result_.walk.steps, frames_, rate(), result_.start);
    result_.keyframe_times_s.clear();
    for (const DrawnStep& step : result_.walk.steps) result_.keyframe_times_s.push_back(step.start / rate());
    result_.keyframe_times_s.push_back(result_.walk.steps.back().end / rate());
    ApplyPoseGoals(problem_, result_.keyframe_times_s, &result_.clip);
    result_.evaluation = EvaluateClip(result_.clip);
    result_.outcomes = MeasureControls(problem_, result_.keyframe_times_s, {result_.clip, result_.evaluation.contacts});
  }

  static std::ptrdiff_t Unmet(const SteeredWalk& walk) {
    return std::count_if(walk.outcomes.begin(), walk.outcomes.end(), [](const ControlOutcome& outcome) { return !outcome.met; });
  }

  // The largest residual, in parts of what is enough.
  double WorstMiss() const {
    double worst = 0;
    for (const ControlOutcome& outcome : result_.outcomes) {
      const double enough = outcome.tolerance * (outcome.is_mean ? kEnoughOnTheWhole : kEnough);
      worst = std::max(worst, enough > 0 ? outcome.residual / enough : outcome.residual > 0 ? 2 + 100 * outcome.residual : 0.0);
    }
    return worst;
  }

  // Where terms have not come out, those that hold over many frames and those that arms and head finish are asked for more sternly. True
  // where that is news.
  bool Tighten() {
    if (result_.walk.steps.empty() || result_.all_met() || mean_part_ < kSternest) return false;
    mean_part_ /= 2;
    loose_part_ /= 4;
    return true;
  }

  // Puts the places where the clip has them, and keeps what the joins added.
  void TakeOverPlaces() {
    if (begins_inside()) {
      const Eigen::Vector3d root = MeasuredRoot(0);
      places_[0] = PlaceBefore(*kinematics_[0], latents_[0], {root[0], root[1], root[2], 0}, result_.keyframe_times_s[0]);
    }
    for (size_t k = begins_inside() ? 1 : 0; k <= steps_.size(); ++k) {
      const double frame = result_.keyframe_times_s[k] * rate();
      if (k == 0 || frame <= frames_ - 1) {
        const int low = std::clamp(static_cast<int>(frame), 0, frames_ - 2);
        const double t = frame - low;
        const Eigen::Vector3d a = MeasuredRoot(low), b = MeasuredRoot(low + 1);
        Eigen::Vector3d there = a + t * (b - a);
        there[2] = a[2] + t * std::remainder(b[2] - a[2], 2 * M_PI);
        there[2] = places_[k][kPlaceHeading] + std::remainder(there[2] - places_[k][kPlaceHeading], 2 * M_PI);
        if (k > 0) {
          const KeyframePlace model = kinematics_[k - 1]->Next(latents_[k - 1], places_[k - 1]).value;
          const Eigen::Vector3d added = there - model.head<3>();
          joins_[k - 1] = Turned(-places_[k - 1][kPlaceHeading], added);
        }
        places_[k].head<3>() = there;
      } else {
        const Eigen::Vector3d joined = Turned(places_[k - 1][kPlaceHeading], joins_[k - 1]);
        places_[k] = kinematics_[k - 1]->Next(latents_[k - 1], places_[k - 1]).value;
        places_[k].head<3>() += joined;
      }
      places_[k][kPlaceTime] = result_.keyframe_times_s[k];
      if (problem_.guide.path) {
        const double before = k > 0 ? along_m_[k - 1] : 0;
        along_m_[k] = problem_.guide.path->NearestTo(places_[k].head<2>(), before - 0.2, before + 2).along_m;
      }
    }
  }

  const ControlProblem& problem_;
  const MotionGraph& graph_;
  std::vector<WalkStep> steps_;
  std::vector<std::shared_ptr<const StepKinematics>> kinematics_;
  std::vector<StepInnovation> innovations_;
  std::vector<Eigen::VectorXd> drawn_;  // innovations
  std::vector<Eigen::MatrixXd> covariances_;  // of a step's latent and the one's before
  Eigen::VectorXd first_;               // drawn latent of the first step
  std::vector<Eigen::Vector3d> joins_;  // what a clip's joins add to the steps, see NextPlaceResidual
  std::vector<double> along_m_;
  int frames_;
  double mean_part_ = kMean;  // of the tolerance, that terms over many frames may deviate by
  double loose_part_ = 1;     // of the deviations of what arms and head finish
  std::vector<Eigen::VectorXd> latents_;
  std::vector<KeyframePlace> places_;
  std::list<Eigen::Vector3d> offsets_;  // of the terms of the present solution
  std::vector<std::vector<Eigen::RowVectorXd>> directions_;  // of each step's latent, that the terms depend on
  Eigen::MatrixXd readings_;  // that the walk is held to
  SteeredWalk result_;
};

}  // namespace

bool SteeredWalk::all_met() const {
  return std::all_of(outcomes.begin(), outcomes.end(), [](const ControlOutcome& outcome) { return outcome.met; });
}

PosteriorDraw DrawPosterior(const SensorGuide& sensors, std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  PosteriorDraw draw;
  for (const DrawnStep& step : sensors.walk.steps) {
    Eigen::VectorXd& innovation = draw.innovations.emplace_back(step.step.whitened.size());
    for (double& value : innovation) value = normal(rng);
  }
  draw.readings_m_s2.resizeLike(sensors.readings);
  for (double& value : draw.readings_m_s2.reshaped()) value = kSensor_m_s2 * normal(rng);
  return draw;
}

SteeredWalk OptimizeWalk(const ControlProblem& problem, const WalkPlan& plan, KinematicsCache* kinematics, const PosteriorDraw& draw) {
  return Optimizer(problem, plan, kinematics, draw).Run();
}

}  // namespace morphograph
