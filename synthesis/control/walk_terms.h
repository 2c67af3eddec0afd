#pragma once

#include <list>
#include <vector>

#include "synthesis/control/residuals/control_residuals.h"
#include "synthesis/control/walk_state.h"

namespace ceres {
class Problem;
}

namespace morphograph {

/// Deviation of a reading about what a step says (m/s^2): noise, mounting, and what the model does not hold (METHODS section 5).
inline constexpr double kReadingDeviation_m_s2 = 1.5;
/// Part of its tolerance within which a term is as good as met.
inline constexpr double kEnough = 0.5;

/// How sternly terms are asked for that walks do not meet at once.
struct TermSternness {
  double mean_part = 0.4;  // of the tolerance, that terms over many frames may deviate by: bodies sway
  double loose_part = 1;   // of the deviations of what arms and head finish by themselves
};

/// Puts what a request asks for into the equations of one solution: a residual block a term and moment.
///
/// Where there is a clip, what it does is measured: the difference from what the steps alone say goes into the blocks as an offset.
class WalkTerms {
 public:
  /// @param equations  get the blocks, which refer to the unknowns of `walk` and to this object until they are solved.
  WalkTerms(WalkState* walk, const TermSternness& sternness, ceres::Problem* equations);

  void AddAll();
  /// What the terms say of a step's latent: rows in whose span it has to be able to move, by step.
  const std::vector<std::vector<Eigen::RowVectorXd>>& directions() const { return directions_; }
  /// What it takes to evaluate all terms once, in units of SteerBudget.
  double work() const { return work_; }

 private:
  using Moment = WalkState::Moment;

  // A term of one step. What it says of the step's latent is one of the directions in which that one may move.
  void Add(StepResidual* residual, size_t step, double work = 1);
  Eigen::Vector3d* NewOffset();
  void AddRoot(const Moment& at, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation);
  void AddJoint(const Moment& at, const ResolvedJoint& joint, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation,
                const std::optional<Eigen::Vector3d>& measured);
  void AddPathAndGoal();
  void AddSensors();
  void AddConstraints();
  void AddSwings();
  void AddReach();
  void AddPoint(const Moment& at, const ResolvedJoint& joint, const Eigen::Vector3d& target, const bool* use, double tolerance_m);
  void AddTerm(const PositionTerm& term, const std::vector<ResolvedJoint>& joints);
  void AddTerm(const OrientationTerm& term, const std::vector<ResolvedJoint>& joints);
  void AddTerm(const TrajectoryTerm& term, const std::vector<ResolvedJoint>& joints);
  void AddTerm(const HeadingTerm& term, const std::vector<ResolvedJoint>&);
  void AddTerm(const FootstepTerm& term, const std::vector<ResolvedJoint>&);
  void AddTerm(const KeepOutTerm& term, const std::vector<ResolvedJoint>&);
  void AddTerm(const LookAtTerm& term, const std::vector<ResolvedJoint>&);
  void AddTerm(const PoseTerm& term, const std::vector<ResolvedJoint>& joints);

  WalkState& walk_;
  const ControlProblem& problem_;
  const TermSternness sternness_;
  ceres::Problem* equations_;
  std::list<Eigen::Vector3d> offsets_;
  std::vector<std::vector<Eigen::RowVectorXd>> directions_;
  double work_ = 0;
  double weight_ = 1;  // of the term that is being added
};

}  // namespace morphograph
