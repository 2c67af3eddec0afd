#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

namespace morphograph {

struct RandomForestOptions {
  int trees = 200;
  int features = 0;  // tried at a node; 0: the square root of how many there are
};

/// A random forest of two classes (Breiman 2001) that gives probabilities: each tree is grown on a bootstrap sample until its
/// leaves are pure, and the shares of class 1 in the leaves that a sample falls into are averaged.
///
/// A split is the best by the Gini index among features drawn for its node. Differs from the source: values are first sorted into
/// up to 256 bins of equal counts, and splits lie between bins. An exact search sorts at every node, which made OpenCV's
/// forest some twenty times slower here, too slow for the hundreds of forests that a study grows.
class RandomForest {
 public:
  /// @param samples  (features x N), finite. @param labels  (N), 0 or 1.
  /// @throws std::invalid_argument when sizes do not fit, a class has no sample, or an option is out of range.
  RandomForest(const Eigen::MatrixXf& samples, const std::vector<char>& labels, const RandomForestOptions& options,
               std::mt19937_64& rng);

  /// Probability of class 1, (N), for samples (features x N). @throws std::invalid_argument when the features differ.
  Eigen::VectorXd Predict(const Eigen::MatrixXf& samples) const;

 private:
  struct Node {
    int feature = -1;    // -1: a leaf
    int last_bin = 0;    // of the left child, which is the next node; the right one is `right`
    int right = 0;
    float probability = 0;
  };
  class TreeGrower;

  Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> Binned(const Eigen::MatrixXf& samples) const;

  std::vector<std::vector<float>> edges_;  // per feature: greatest value of each bin but the last
  std::vector<std::vector<Node>> trees_;
};

}  // namespace morphograph
