#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph::internal {

/// Linear regressions that belong together, as those of one quantity at every time of a step, each of inputs and examples of its own: every
/// output has one ridge for all of them, the one that predicts best the groups which it has not seen. What none predicts better than
/// the mean, by a fiftieth of its energy, is 0.
class HeldOutRidge {
 public:
  /// @param energy  mean square of an input, over all examples that there are: what ridges are parts of, an example each.
  HeldOutRidge(int outputs, double energy);

  /// One more regression. @param inputs  (D x N) and @param outputs  (outputs x N), both without their means. @param groups  per example.
  void Add(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const std::vector<int>& groups);

  /// The maps (outputs x D), in the order added.
  std::vector<Eigen::MatrixXd> Maps() const;

 private:
  double energy_;
  std::vector<std::vector<Eigen::MatrixXd>> maps_;  // by regression, by ridge
  Eigen::MatrixXd missed_;                          // (outputs x ridges) squared errors on groups left out
  Eigen::VectorXd whole_;                           // (outputs) squared outputs
};

}  // namespace morphograph::internal
