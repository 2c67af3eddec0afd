#pragma once

#include <Eigen/Core>
#include <memory>

#include "primitives/locally_linear_embedding.h"

namespace morphograph {

enum class ReductionKind { kPca, kLle };

struct PoseReductionOptions {
  ReductionKind kind = ReductionKind::kPca;
  int components = 40;  // Xie takes 7, of each cluster; these are of all, cost little, and lose a millimetre; fewer where poses have fewer channels
  /// Of LLE (Xie 5.1.3, 5.1.4): neighbours of a sample, what keeps their weights from growing, and how many samples are embedded, evenly taken: its cost
  /// grows with their square. Other poses are placed by their neighbours among these.
  int neighbours = 48;
  double regularisation = 0.001;
  int samples = 2500;
};

/// Poses in few coordinates (Xie 5.1): principal components, or locally linear embedding. Immutable.
class PoseReduction {
 public:
  /// @param poses  (channels x frames), PoseChannels::Vectors(). @throws std::invalid_argument for options out of range or too few frames.
  PoseReduction(const Eigen::MatrixXf& poses, const PoseReductionOptions& options);

  int components() const { return static_cast<int>(spreads_.size()); }
  const PoseReductionOptions& options() const { return options_; }
  /// Standard deviation of each coordinate over the poses.
  const Eigen::VectorXd& spreads() const { return spreads_; }
  /// Coordinates of poses, (components x frames). @param jobs  threads; they do not alter it.
  Eigen::MatrixXf Coordinates(const Eigen::MatrixXf& poses, int jobs = 1) const;
  /// The pose (channels) of coordinates.
  Eigen::VectorXd Pose(const Eigen::VectorXd& coordinates) const;

 private:
  PoseReductionOptions options_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd axes_;  // (channels x components) of PCA; LLE works in the leading ones too, there being little else
  Eigen::VectorXd spreads_;
  std::shared_ptr<const LocallyLinearEmbedding> embedding_;  // of the poses' coordinates along axes_
};

}  // namespace morphograph
