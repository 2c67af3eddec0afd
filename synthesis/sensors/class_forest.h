#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace morphograph {

struct ClassForestOptions {
  int trees = 32;
  int depth = 13;
  int most_samples = 120000;  // that trees are grown on, taken evenly; shares in leaves are of all
  std::uint64_t seed = 1;
};

/// A random forest of many classes that gives probabilities in microseconds (Breiman 2001).
///
/// XGBoost grows the trees; its own prediction costs tens of microseconds a call, so they are kept as plain tables here. A tree of XGBoost has one
/// target, so each tells two random halves of the classes apart (error-correcting codes: Dietterich & Bakiri 1995), on its own part of the samples and with
/// features drawn at every node; in its leaves stand the shares of all classes among the samples that fall there. Probabilities are the trees' mean.
class ClassForest {
 public:
  /// @param samples  (features x N), finite. @param labels  (N), from 0. @param classes  more than the largest label.
  /// @throws std::invalid_argument for sizes that do not fit, labels out of range, values that are not finite.
  ClassForest(const Eigen::MatrixXf& samples, const std::vector<int>& labels, int classes, const ClassForestOptions& options);

  int classes() const { return static_cast<int>(shares_.rows()); }
  /// (classes), summing to 1.
  Eigen::VectorXf Probabilities(const Eigen::VectorXf& sample) const;

 private:
  struct Node {
    int feature = -1;     // -1: a leaf, `left` is then a column of shares_
    float threshold = 0;  // below it to the left
    int left = 0, right = 0;
  };
  int LeafOf(int root, const Eigen::VectorXf& sample) const;

  std::vector<Node> nodes_;
  std::vector<int> roots_;
  Eigen::MatrixXf shares_;  // (classes x leaves)
};

}  // namespace morphograph
