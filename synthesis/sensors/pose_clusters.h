#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "synthesis/sensors/motion_base.h"

namespace morphograph {

struct PoseClusterOptions {
  int components = 7;        // leading coordinates that the mixture is of (Xie 5.2)
  int max_clusters = 96;
  int fit_frames = 8000;     // frames taken evenly to fit the mixture; all are then assigned
  double noise_m_s2 = 0.5;   // of sensors to come, standard deviation; those of a base have none, and clusters would be told too surely
  std::uint64_t seed = 1;
};

/// Poses of a base in clusters by a Gaussian mixture, and what the sensors read in each (Xie 5.2). Immutable.
///
/// The number of clusters has the minimum description length, -ln L + 1/2 p ln (N D) with p parameters (Rissanen; Bouman's criterion, which Xie 5.2.3
/// uses), of those tried: 1, 2, 3, 4, 6, 8, 12, … until two in a row are no better.
struct PoseClusters {
  std::vector<int> of_frame;              // cluster of each frame of the base
  Eigen::MatrixXf means;                  // (readings x clusters): of what is read
  std::vector<Eigen::MatrixXf> whitening;   // L^-1 of the readings' covariance L L^T, one a cluster
  Eigen::VectorXf log_scales;             // -ln |L|
  /// (clusters x clusters): chance that a frame in cluster `column` is followed by one in cluster `row`, counted in the base.
  Eigen::MatrixXf transitions;
  struct Candidate {
    int clusters = 0;
    double description_length = 0;
  };
  std::vector<Candidate> candidates;      // in the order tried

  int count() const { return static_cast<int>(means.cols()); }
};

/// @param coordinates  (components x frames of the base), of PoseReduction.
/// @throws std::invalid_argument for a base without sensors, or other sizes.
PoseClusters ClusterPoses(const MotionBase& base, const Eigen::MatrixXf& coordinates, const PoseClusterOptions& options, int jobs = 1);

enum class ClusterChoice {
  kNearestMean,  // the cluster whose mean reading is nearest, frame by frame (Xie 6.1)
  kFiltered,     // probabilities, from all readings so far: a hidden Markov model's forward pass
};

/// Tells from readings, frame after frame, which clusters the body may be in. One for each stream.
class ClusterFilter {
 public:
  /// @param evidence  power to which likelihoods of readings are taken. Readings of neighbouring frames err alike, so it is far below 1.
  ClusterFilter(const PoseClusters& clusters, ClusterChoice choice, double evidence);
  /// Probability of each cluster, (clusters), at the present frame.
  /// @param surprise  variance of readings' errors of late, times that in the base, 1 or more: evidence is worth so many times less.
  const Eigen::VectorXf& Next(const Eigen::VectorXf& reading, double surprise = 1);

 private:
  const PoseClusters& clusters_;
  ClusterChoice choice_;
  float evidence_;
  Eigen::VectorXf probabilities_;
};

}  // namespace morphograph
