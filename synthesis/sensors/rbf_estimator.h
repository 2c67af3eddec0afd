#pragma once

#include <memory>
#include <vector>

#include "synthesis/sensors/pose_channels.h"
#include "synthesis/sensors/pose_clusters.h"
#include "synthesis/sensors/pose_estimator.h"
#include "synthesis/sensors/pose_reduction.h"
#include "synthesis/sensors/radial_basis_map.h"

namespace morphograph {

struct RbfOptions {
  PoseReductionOptions reduction;
  PoseClusterOptions clusters;
  RadialBasisOptions map;
  ClusterChoice choice = ClusterChoice::kFiltered;
  double evidence = 0.3;
  int window = 8;  // frames that are averaged (Xie 6.1.1); 1: none
  int jobs = 1;
};

/// What the method learns of a base (Xie chapter 5). Immutable; streams share it.
struct RbfModel {
  RbfModel(const MotionBase& base, const RbfOptions& options);

  RbfOptions options;
  PoseChannels channels;
  PoseReduction reduction;
  PoseClusters clusters;
  /// One a cluster: from a reading to coordinates of the pose now, of the next frame's, … as many as the window has.
  std::vector<RadialBasisMap> maps;
};

/// Poses from readings by radial basis functions (Xie 6.1).
///
/// Xie takes the cluster whose mean reading is nearest, and averages poses over t-4 … t+3, which needs readings that are yet to come. Here
/// clusters are told from all readings so far, and each reading foretells the poses of the next frames as well; the pose given is the mean of what the
/// last 8 readings said of this very frame. So there is a window and no delay.
class RbfEstimator : public PoseEstimator {
 public:
  explicit RbfEstimator(std::shared_ptr<const RbfModel> model);
  BasePose Next(const Eigen::VectorXd& reading) override;

 private:
  std::shared_ptr<const RbfModel> model_;
  ClusterFilter filter_;
  Eigen::MatrixXf said_;  // (components * window x window): a column a reading, the latest at said_count_ - 1 (cyclic)
  Eigen::Index said_count_ = 0;
};

}  // namespace morphograph
