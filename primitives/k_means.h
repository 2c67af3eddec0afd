#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

namespace morphograph {

/// Samples in clusters, each nearest to its own cluster's mean.
struct KMeans {
  std::vector<int> of_sample;
  Eigen::MatrixXd centres;  // (D x clusters)
};

/// k-means++ (Arthur & Vassilvitskii 2007), then at most `iterations` of Lloyd's. A cluster that loses all its samples keeps its centre.
/// @param samples  (D x N), N >= 1. Fewer clusters come back where the samples have fewer distinct values.
KMeans FitKMeans(const Eigen::MatrixXd& samples, int clusters, int iterations, std::mt19937_64& rng);

}  // namespace morphograph
