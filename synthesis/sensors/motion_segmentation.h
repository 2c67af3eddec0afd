#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace morphograph {

struct SegmentationOptions {
  double first_s = 0.5;     // of motion that the first model is of, and that it is tried on
  double step_s = 0.1;      // between trials
  double variance_kept = 0.95;
  double rise = 0.25;       // of the Mahalanobis distance (mean square per dimension) above its last valley that cuts
};

/// Cuts a motion where the distribution of its poses changes (probabilistic PCA; Barbic et al. 2004, which Liu 3.2.2 uses).
///
/// A Gaussian with full covariance along the leading axes and the mean of the rest across (Tipping & Bishop 1999) is fitted to the frames so far, and the
/// mean squared Mahalanobis distance of the next second of frames is taken; so on as frames are added. It falls while poses are
/// of the same kind; at a peak that follows a valley by more than `rise`, a new segment begins. Distances are per dimension, about 1 for more of the same.
///
/// @param poses  (dimensions x frames) of one clip. @return first frames of the segments, 0 first.
std::vector<Eigen::Index> CutMotion(const Eigen::MatrixXd& poses, double frame_rate_hz, const SegmentationOptions& options);

struct SegmentClusterOptions {
  double covariance_weight = 0.8;  // Liu's w, of what tells segments apart; 1 - w for the mean
  double variance_kept = 0.95;     // of the segments' features, in principal components
  double tolerance = 0.5;          // of segments from their cluster's mean, times their root mean square distance from the mean of all
  int least_frames = 400;          // a cluster is not split when a part would have fewer
  int most_clusters = 64;
  std::uint64_t seed = 1;
};

/// Clusters of segments that lie in one linear space (Liu 3.2.2, 3.2.3): each segment is [w v, (1 - w) m], with m the mean of its poses and v the entries of
/// their covariance, in units of their spread over all segments; clusters are split by 2-means, the widest first, until all segments are within the tolerance.
/// @param segments  poses, (dimensions x frames) each. @return the cluster of each, from 0 without gaps.
std::vector<int> ClusterSegments(const std::vector<Eigen::MatrixXd>& segments, const SegmentClusterOptions& options);

}  // namespace morphograph
