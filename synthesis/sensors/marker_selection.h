#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace morphograph {

struct MarkerSelectionOptions {
  int count = 6;
  double variance_kept = 0.95;  // of the principal components whose loadings are clustered
  int restarts = 40;            // of the clustering
  std::uint64_t seed = 1;
};

/// Principal markers (Liu 3.1.1, after the principal feature analysis of Cohen et al. 2002): the markers that say most of all others.
///
/// The rows of the leading eigenvectors, in absolute value, are clustered by k-means, so that coordinates which go together share a cluster; markers
/// that lie in fewest clusters (of equals, those farthest from their clusters' means) are taken out one by one while every cluster stays covered.
///
/// Differs from Liu: that leaves the number of markers open. Here they go until `count` are left, and where the cover would need more, those go on leaving that
/// matter least. Of several starts of the clustering, the set is taken from which a linear map makes all markers with the least error.
///
/// @param tracks  (3 * markers x frames). @return indices of markers, in order.
/// @throws std::invalid_argument for fewer markers than `count`, or a count below 1.
std::vector<int> PrincipalMarkers(const Eigen::MatrixXf& tracks, const MarkerSelectionOptions& options);

}  // namespace morphograph
