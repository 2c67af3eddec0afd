#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

/// What stays the same over a walk. A walk has a manner of its own (how high a foot is lifted, how an arm is held), and its steps vary
/// about it: a linear mixed model with the walk as its random effect (Laird & Ware 1982).
///
/// Of a whitened latent, w = m + sqrt(1 - b) z, value by value: m ~ (0, b) is the manner, z ~ (0, 1) what changes from step to step.
/// An empty model has no manner: b = 0.
struct MannerModel {
  Eigen::VectorXd share;     // b (D), in [0, 1)
  /// Best linear prediction of m for each captured walk, (D x walks). Column c is the same walk in every
  /// primitive of a style, so that a manner is one of the whole body and of both legs.
  Eigen::MatrixXf captured;
  /// How often each captured walk's steps met each mixture component, (mixture components x walks), columns summing to 1; the mixture's weights
  /// where it has no steps of this primitive.
  Eigen::MatrixXf met;
  /// Factors on the chances of entering a component with which walks of each manner meet them as often (BalanceComponents), likewise.
  Eigen::MatrixXf components;
  std::vector<int> steps;    // (walks) steps of this primitive that a column rests on; 0: nothing is known, the column is 0
  std::vector<float> seconds;  // (walks) that these took

  bool empty() const { return share.size() == 0; }
  int walks() const { return static_cast<int>(steps.size()); }
  /// sqrt(1 - b), or ones for an empty model. (D)
  Eigen::VectorXd WithinScale(Eigen::Index dimension) const {
    return empty() ? Eigen::VectorXd::Ones(dimension) : Eigen::VectorXd((1 - share.array()).sqrt());
  }
};

}  // namespace morphograph
