#include "synthesis/control/walk_optimizer.h"

#include <Eigen/QR>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>
#include <tuple>

#include "synthesis/control/foot_landings.h"
#include "synthesis/control/pose_goals.h"
#include "synthesis/control/residuals/latent_subspace.h"
#include "synthesis/control/walk_terms.h"
#include "synthesis/step_track.h"
#include "synthesis/walk_clip.h"

namespace morphograph {
namespace {

constexpr int kRounds = 4;
constexpr int kFirstIterations = 8, kLaterIterations = 4;
constexpr double kShortWalk = 20;  // steps; in longer ones what joins leave loose would add up
constexpr double kSternest = 0.15;  // part of a tolerance, see TermSternness
// Part of the tolerances of means over a whole clip, which another round hardly changes, within which nothing more is done; see kEnough for the rest.
constexpr double kEnoughOnTheWhole = 0.9;
constexpr double kHelps = 0.5, kProgress = 0.95;  // of the largest residual, from round to round; more is none
// Norms of latents, in the largest of the training: how far outside of it they are likely to be moved, and how far at most.
constexpr double kRadius = 0.02, kFarthest = 0.15;
constexpr double kSwingGive = 0.05;       // part of the range of swings that one may be beyond it
constexpr double kFoundTime_s = 0.02;     // deviation of the first key frame of steps that were found in readings
constexpr double kPose = 0.3, kFrame = 1.5;  // units of SteerBudget: a pose of arms or head, a frame of a clip that is made and measured
constexpr int kFewestIterations = 3;      // of a solution, however little is left of the budget
constexpr double kFreeHeading_rad = 0.2;  // deviation of a start whose heading was not asked for

Eigen::Vector3d Turned(double heading, const Eigen::Vector3d& local) {
  const double c = std::cos(heading), s = std::sin(heading);
  return {c * local[0] + s * local[1], -s * local[0] + c * local[1], local[2]};
}

class Optimizer {
 public:
  Optimizer(const ControlProblem& problem, const WalkPlan& plan, KinematicsCache* kinematics, SteerBudget* budget, const PosteriorDraw& draw)
      : problem_(problem), budget_(*budget), graph_(problem.graph), kinematics_(*kinematics), walk_{.problem = problem, .steps = plan.steps, .places = plan.places, .along_m = plan.along_m, .frames = plan.frames} {
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      walk_.kinematics.push_back(kinematics->Of(walk_.steps[k]));
      walk_.latents.push_back(walk_.steps[k].whitened);
      if (k == 0) continue;
      innovations_.emplace_back(graph_, walk_.steps[k - 1], walk_.steps[k]);
      drawn_.push_back(innovations_.back().Value(walk_.latents[k - 1], walk_.latents[k]));
      covariances_.push_back(innovations_.back().Covariance());
    }
    first_ = walk_.latents[0];
    if (!draw.innovations.empty()) {
      const WithinWalk within = WithinWalkOf(graph_, walk_.steps[0]);
      first_ = within.manner + within.scale.cwiseProduct(draw.innovations[0]);
    }
    for (size_t k = 1; k < std::min(walk_.steps.size(), draw.innovations.size()); ++k) drawn_[k - 1] = draw.innovations[k];
    if (problem_.sensors) {
      walk_.readings = problem_.sensors->readings;
      if (draw.readings_m_s2.size() > 0) walk_.readings += draw.readings_m_s2;
    }
    joins_.assign(walk_.steps.size(), Eigen::Vector3d::Zero());
    walk_.swings.resize(walk_.steps.size());
    times_beyond_.resize(walk_.steps.size());
    walk_.made.start = problem_.guide.start;
    walk_.made.start.heading_rad = walk_.FirstHeading();
  }

  SteeredWalk Run() {
    SteeredWalk best;
    double least = std::numeric_limits<double>::infinity();
    const int rounds = kRounds + static_cast<int>(walk_.steps.size()) / 40;
    for (int round = 0; round < rounds; ++round) {
      // Long walks bend farther before they are where they should be.
      Solve((round == 0 ? kFirstIterations : kLaterIterations) + static_cast<int>(walk_.steps.size()) / 10);
      MakeClip();
      const bool holds_more = HoldSwings();
      const double worst = WorstMiss(), before = least;
      const auto rank = [](const SteeredWalk& walk, double miss) { return std::tuple(Unmet(walk), std::max(0.0, walk.swing_excess - kSwingGive), miss); };
      if (round == 0 || rank(walk_.made, worst) < rank(best, least)) {
        least = worst;
        best = walk_.made;
      }
      // While rounds still help by themselves, and in long walks at first, what is missing is only that clips are not what the steps alone say.
      const bool helps = round == 0 ? walk_.steps.size() > 2 * kShortWalk : worst < kHelps * before;
      const bool tightened = !helps && Tighten();
      if (holds_more && !budget_.spent()) {
        TakeOverPlaces();
        continue;
      }
      if (least <= 1 || budget_.spent() || (round > 0 && !helps && !tightened && worst > kProgress * before)) break;
      TakeOverPlaces();
    }
    return best;
  }

 private:
  void AddPrior(ceres::Problem* problem) {
    problem->AddResidualBlock(new FirstStepResidual(first_, WithinWalkOf(graph_, walk_.steps[0]).scale), nullptr, walk_.latents[0].data());
    const double heading = problem_.guide.free_heading ? kFreeHeading_rad : 1e-4;
    problem->AddResidualBlock(new StartResidual(walk_.places[0], {1e-4, 1e-4, heading, walk_.begins_inside() ? kFoundTime_s : 1e-4}), nullptr, walk_.places[0].data());
    const double looseness = std::min(1.0, kShortWalk / static_cast<double>(walk_.steps.size()));
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      if (const double radius = graph_.primitive(walk_.steps[k].primitive).latent_radius; radius > 0) {
        const int dimension = static_cast<int>(walk_.latents[k].size());
        problem->AddResidualBlock(new RadiusResidual(dimension, std::max(radius, walk_.steps[k].whitened.norm()), kRadius * radius), nullptr, walk_.latents[k].data());
      }
      if (k > 0) problem->AddResidualBlock(new InnovationResidual(innovations_[k - 1], drawn_[k - 1]), nullptr, walk_.latents[k - 1].data(), walk_.latents[k].data());
      problem->AddResidualBlock(new NextPlaceResidual(walk_.kinematics[k], &joins_[k], looseness), nullptr, walk_.latents[k].data(), walk_.places[k].data(), walk_.places[k + 1].data());
    }
  }

  // Latents move in the directions that the terms and the way to the next key frame depend on, and in those that transitions carry over from
  // the ways of the neighbours. In whitened space, where the prior is the same all around, there is next to no reason for others, and the
  // equations become a tenth as large.
  void RestrictLatents(std::vector<std::vector<Eigen::RowVectorXd>> all_directions, ceres::Problem* problem) {
    std::vector<Eigen::MatrixXd> ways;
    for (size_t k = 0; k < walk_.steps.size(); ++k) ways.push_back(walk_.kinematics[k]->Next(walk_.latents[k], walk_.places[k]).by_latent);
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      auto& directions = all_directions[k];
      const auto add = [&](const Eigen::MatrixXd& more) {
        for (Eigen::Index r = 0; r < more.rows(); ++r) directions.push_back(more.row(r));
      };
      add(ways[k]);
      if (k > 0) add(ways[k - 1] * covariances_[k - 1].transpose());
      if (k + 1 < walk_.steps.size()) add(ways[k + 1] * covariances_[k]);
      Eigen::MatrixXd rows(static_cast<Eigen::Index>(directions.size()), walk_.latents[k].size());
      for (size_t r = 0; r < directions.size(); ++r) rows.row(static_cast<Eigen::Index>(r)) = directions[r];
      for (Eigen::Index r = 0; r < rows.rows(); ++r) {
        if (const double norm = rows.row(r).norm(); norm > 1e-9) rows.row(r) /= norm;
      }
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows.transpose());
      qr.setThreshold(1e-4);
      const Eigen::Index rank = qr.rank();
      if (rank == 0 || rank == rows.cols()) continue;
      problem->SetManifold(walk_.latents[k].data(), new LatentSubspace(qr.householderQ() * Eigen::MatrixXd::Identity(rows.cols(), rank)));
    }
  }

  void Solve(int iterations) {
    ceres::Problem problem;
    AddPrior(&problem);
    WalkTerms terms(&walk_, sternness_, &problem);
    terms.AddAll();
    RestrictLatents(terms.directions(), &problem);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    const double work = problem.NumResidualBlocks() + terms.work();
    options.max_num_iterations = std::clamp(static_cast<int>(std::max(0.0, budget_.left()) / work), std::min(iterations, kFewestIterations), iterations);
    options.function_tolerance = 1e-3;
    options.trust_region_strategy_type = ceres::DOGLEG;  // shortens steps for which the places of key frames are too stiff
    options.initial_trust_region_radius = 300 * std::max(1.0, std::pow(static_cast<double>(walk_.steps.size()) / kShortWalk, 1.5));
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    budget_.Take(work * static_cast<double>(summary.iterations.size()));
    KeepBelievable();
  }

  // Steps that were moved farther out than anything captured go back towards the plan: a walk that would need them cannot be had.
  void KeepBelievable() {
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      const double radius = graph_.primitive(walk_.steps[k].primitive).latent_radius;
      const Eigen::VectorXd& planned = walk_.steps[k].whitened;
      // Steps after a start lie far out as they are drawn.
      const double limit = std::max(radius, planned.norm()) + kFarthest * radius;
      if (!(radius > 0) || walk_.latents[k].norm() <= limit) continue;
      // The point between plan and solution where the norm is at its limit.
      const Eigen::VectorXd moved = walk_.latents[k] - planned;
      const double a = moved.squaredNorm(), b = planned.dot(moved), c = planned.squaredNorm() - limit * limit;
      const double part = std::clamp((-b + std::sqrt(std::max(0.0, b * b - a * c))) / a, 0.0, 1.0);
      walk_.latents[k] = planned + part * moved;
    }
  }

  void MakeClip() {
    walk_.made.walk.steps.clear();
    double time = 0;
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      WalkStep step = walk_.steps[k];
      MoveTo(graph_, walk_.latents[k], &step);
      step.log_likelihood = k > 0 ? innovations_[k - 1].LogLikelihood(walk_.latents[k - 1], walk_.latents[k])
                                  : graph_.primitive(step.primitive).mixture.LogDensity(step.latent);
      StepShape shape = graph_.primitive(step.primitive).Shape(step.latent);
      const double length = shape.duration_s * walk_.rate();
      if (k == 0 && problem_.guide.from != WalkBoundary::kWalking) time = MarginBefore(shape) * length;
      if (k == 0 && walk_.begins_inside()) time = std::min(0.0, walk_.places[0][kPlaceTime] * walk_.rate());
      walk_.made.walk.steps.push_back({std::move(step), std::move(shape), time, time + length});
      time += length;
    }
    if (const auto keyframe = walk_.LastKeyframe()) {
      const DrawnStep& last = walk_.made.walk.steps[*keyframe - 1];
      const double margin = walk_.stops() ? MarginAfter(last.shape) * (last.end - last.start) : 0;
      walk_.frames = std::max(2, static_cast<int>(std::floor(last.end + margin)) + 1);
    }
    walk_.made.walk.frames = walk_.frames;
    if (problem_.guide.free_heading) walk_.made.start.heading_rad = walk_.FirstHeading();
    walk_.made.clip = MakeWalkClip(graph_, walk_.made.walk.steps, walk_.frames, walk_.rate(), walk_.made.start);
    walk_.made.keyframe_times_s.clear();
    for (const DrawnStep& step : walk_.made.walk.steps) walk_.made.keyframe_times_s.push_back(step.start / walk_.rate());
    walk_.made.keyframe_times_s.push_back(walk_.made.walk.steps.back().end / walk_.rate());
    budget_.Take(kPose * ApplyPoseGoals(problem_, walk_.made.keyframe_times_s, &walk_.made.clip) + kFrame * walk_.frames);
    walk_.made.evaluation = EvaluateClip(walk_.made.clip);
    walk_.made.outcomes = MeasureControls(problem_, walk_.made.keyframe_times_s, {walk_.made.clip, walk_.made.evaluation.contacts});
  }

  // Measures the swings of the clip, and has those held from now on that no walker would make. True where that is news.
  bool HoldSwings() {
    bool news = false;
    walk_.made.swing_excess = 0;
    for (size_t k = 0; k < walk_.steps.size(); ++k) {
      const int side = LandingFoot(graph_.primitive(walk_.steps[k].primitive));
      const DrawnStep& drawn = walk_.made.walk.steps[k];
      const int from = std::max(0, static_cast<int>(std::floor(drawn.start))), to = std::min(walk_.frames - 1, static_cast<int>(std::ceil(drawn.end)));
      if (side < 0 || to <= from) continue;
      const SwingRange& range = kinematics_.SwingsOf(walk_.steps[k], *problem_.ball[side].chain);
      const ClipSwing swing = SwingInClip(walk_.made.clip, side == 0 ? Foot::kLeft : Foot::kRight, from, to);
      const double excess = std::max(swing.speed_m_s / range.speed_m_s, swing.height_m / range.height_m) - 1;
      walk_.made.swing_excess = std::max(walk_.made.swing_excess, excess);
      if (excess <= kSwingGive) continue;
      // Clips swing somewhat faster than the phases of a step tell: what is held already and still too fast is held to as much less.
      SwingRange& held = walk_.swings[k] ? *walk_.swings[k] : walk_.swings[k].emplace(range);
      if (times_beyond_[k]++ > 0) {
        held.speed_m_s *= std::min(1.0, range.speed_m_s / swing.speed_m_s);
        held.height_m *= std::min(1.0, range.height_m / swing.height_m);
      }
      news = true;
    }
    return news;
  }

  static std::ptrdiff_t Unmet(const SteeredWalk& walk) {
    return std::count_if(walk.outcomes.begin(), walk.outcomes.end(), [](const ControlOutcome& outcome) { return !outcome.met; });
  }

  // The largest residual, in parts of what is enough.
  double WorstMiss() const {
    double worst = 0;
    for (const ControlOutcome& outcome : walk_.made.outcomes) {
      const double enough = outcome.tolerance * (outcome.is_mean ? kEnoughOnTheWhole : kEnough);
      worst = std::max(worst, enough > 0 ? outcome.residual / enough : outcome.residual > 0 ? 2 + 100 * outcome.residual : 0.0);
    }
    return worst;
  }

  // Where terms have not come out, those that hold over many frames and those that arms and head finish are asked for more sternly. True
  // where that is news.
  bool Tighten() {
    if (walk_.made.walk.steps.empty() || walk_.made.all_met() || sternness_.mean_part < kSternest) return false;
    sternness_.mean_part /= 2;
    sternness_.loose_part /= 4;
    return true;
  }

  // Puts the places where the clip has them, and keeps what the joins added.
  void TakeOverPlaces() {
    if (walk_.begins_inside()) {
      const Eigen::Vector3d root = walk_.MeasuredRoot(0);
      walk_.places[0] = PlaceBefore(*walk_.kinematics[0], walk_.latents[0], {root[0], root[1], root[2], 0}, walk_.made.keyframe_times_s[0]);
    }
    for (size_t k = walk_.begins_inside() ? 1 : 0; k <= walk_.steps.size(); ++k) {
      const double frame = walk_.made.keyframe_times_s[k] * walk_.rate();
      if (k == 0 || frame <= walk_.frames - 1) {
        const int low = std::clamp(static_cast<int>(frame), 0, walk_.frames - 2);
        const double t = frame - low;
        const Eigen::Vector3d a = walk_.MeasuredRoot(low), b = walk_.MeasuredRoot(low + 1);
        Eigen::Vector3d there = a + t * (b - a);
        there[2] = a[2] + t * std::remainder(b[2] - a[2], 2 * M_PI);
        there[2] = walk_.places[k][kPlaceHeading] + std::remainder(there[2] - walk_.places[k][kPlaceHeading], 2 * M_PI);
        if (k > 0) {
          const KeyframePlace model = walk_.kinematics[k - 1]->Next(walk_.latents[k - 1], walk_.places[k - 1]).value;
          const Eigen::Vector3d added = there - model.head<3>();
          joins_[k - 1] = Turned(-walk_.places[k - 1][kPlaceHeading], added);
        }
        walk_.places[k].head<3>() = there;
      } else {
        const Eigen::Vector3d joined = Turned(walk_.places[k - 1][kPlaceHeading], joins_[k - 1]);
        walk_.places[k] = walk_.kinematics[k - 1]->Next(walk_.latents[k - 1], walk_.places[k - 1]).value;
        walk_.places[k].head<3>() += joined;
      }
      walk_.places[k][kPlaceTime] = walk_.made.keyframe_times_s[k];
      if (problem_.guide.path) {
        const double before = k > 0 ? walk_.along_m[k - 1] : 0;
        walk_.along_m[k] = problem_.guide.path->NearestTo(walk_.places[k].head<2>(), before - 0.2, before + 2).along_m;
      }
    }
  }

  const ControlProblem& problem_;
  SteerBudget& budget_;
  const MotionGraph& graph_;
  KinematicsCache& kinematics_;
  WalkState walk_;
  std::vector<StepInnovation> innovations_;
  std::vector<Eigen::VectorXd> drawn_;        // innovations
  std::vector<Eigen::MatrixXd> covariances_;  // of a step's latent and the one's before
  Eigen::VectorXd first_;                     // drawn latent of the first step
  std::vector<Eigen::Vector3d> joins_;        // what a clip's joins add to the steps, see NextPlaceResidual
  std::vector<int> times_beyond_;            // rounds in which a step's swing was found beyond its range
  TermSternness sternness_;
};

}  // namespace

PosteriorDraw DrawPosterior(const SensorGuide& sensors, std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  PosteriorDraw draw;
  for (const DrawnStep& step : sensors.walk.steps) {
    Eigen::VectorXd& innovation = draw.innovations.emplace_back(step.step.whitened.size());
    for (double& value : innovation) value = normal(rng);
  }
  draw.readings_m_s2.resizeLike(sensors.readings);
  for (double& value : draw.readings_m_s2.reshaped()) value = kReadingDeviation_m_s2 * normal(rng);
  return draw;
}

SteeredWalk OptimizeWalk(const ControlProblem& problem, const WalkPlan& plan, KinematicsCache* kinematics, SteerBudget* budget, const PosteriorDraw& draw) {
  return Optimizer(problem, plan, kinematics, budget, draw).Run();
}

}  // namespace morphograph
