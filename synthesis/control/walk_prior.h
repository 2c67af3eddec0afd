#pragma once

#include <Eigen/Core>

#include "graph/motion_graph.h"
#include "synthesis/graph_walk.h"

namespace morphograph {

/// The noise that leads from one step's whitened latent to the next one's, in units in which the model takes it for N(0, I):
///   e = N^-1 (z' - Mean(z)), z the latents without the manner of the walk (MannerModel), N the Cholesky factor of the transition's noise.
class StepInnovation {
 public:
  /// @param previous, next  steps of a walk that follow each other; their manners are kept, their latents are not used.
  StepInnovation(const MotionGraph& graph, const WalkStep& previous, const WalkStep& next);

  int dimension() const { return static_cast<int>(transition_.noise_cholesky.rows()); }  // of the next step
  int previous_dimension() const { return static_cast<int>(previous_scale_.size()); }
  Eigen::VectorXd Value(const Eigen::VectorXd& previous, const Eigen::VectorXd& next) const;
  /// (dimension x D of the previous), (dimension x D of the next).
  Eigen::MatrixXd ByPrevious(const Eigen::VectorXd& previous) const;
  const Eigen::MatrixXd& ByNext() const { return by_next_; }
  /// Covariance of the next and the previous latent about the walk's manner, as far as transitions are linear: (dimension x D of the previous).
  Eigen::MatrixXd Covariance() const { return next_scale_.asDiagonal() * transition_.linear.cast<double>() * previous_scale_.asDiagonal(); }
  /// ln p(next latent | previous latent), the edge's and the component's chances included.
  double LogLikelihood(const Eigen::VectorXd& previous, const Eigen::VectorXd& next) const;

 private:
  Eigen::VectorXd Within(const Eigen::VectorXd& previous) const { return (previous - previous_manner_).cwiseQuotient(previous_scale_); }

  const TransitionModel& transition_;
  Eigen::VectorXd previous_manner_, previous_scale_, next_manner_, next_scale_;
  Eigen::MatrixXd by_next_, linear_by_previous_;
  double log_constant_ = 0;
};

/// Manner and scale of a step's latents in its walk: w = manner + scale z; nothing and ones where its primitive has none.
struct WithinWalk {
  Eigen::VectorXd manner, scale;
};
WithinWalk WithinWalkOf(const MotionGraph& graph, const WalkStep& step);

/// Gives a step another whitened latent, and the latent that follows from it. Its likelihood is the caller's.
void MoveTo(const MotionGraph& graph, const Eigen::VectorXd& whitened, WalkStep* step);

}  // namespace morphograph
