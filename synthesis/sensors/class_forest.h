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
///
/// For speed, trees go down together a level at a time, so that their memory is fetched at once and no branch waits; and leaves hold only the classes that
/// fall there, few of many, in 2 % of a leaf's samples or more (all of them where none comes to that).
class ClassForest {
 public:
  /// @param samples  (features x N), finite. @param labels  (N), from 0. @param classes  more than the largest label.
  /// @throws std::invalid_argument for sizes that do not fit, labels out of range, values that are not finite.
  ClassForest(const Eigen::MatrixXf& samples, const std::vector<int>& labels, int classes, const ClassForestOptions& options);

  int classes() const { return classes_; }
  /// (classes), summing to 1.
  Eigen::VectorXf Probabilities(const Eigen::VectorXf& sample) const;
  /// The same into `probabilities`, (classes).
  void Probabilities(const Eigen::VectorXf& sample, Eigen::Ref<Eigen::VectorXf> probabilities) const;

 private:
  struct Node {
    float threshold = 0;  // below it to `left`, else to the node after that; of a leaf infinite
    int feature = 0;
    int left = 0;         // of a leaf itself
  };
  struct Share {
    int of_class = 0;
    float share = 0;
  };
  // The leaf of every one of these trees, as places in nodes_, (trees).
  void FindLeaves(const float* sample, int first_tree, int trees, int* leaves) const;

  int classes_ = 0, levels_ = 0;
  std::vector<Node> nodes_;  // the roots first
  int trees_ = 0;
  std::vector<int> first_share_;  // of each node, and one past the last: shares_ of a leaf
  std::vector<Share> shares_;
};

}  // namespace morphograph
