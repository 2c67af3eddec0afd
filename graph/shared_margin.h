#pragma once

#include <Eigen/Core>
#include <vector>

#include "primitives/motion_primitive.h"
#include "primitives/pose_layout.h"

namespace morphograph {

/// The motion that two neighbours share, about the key frame between them: every step is modelled with margins, so that the end of one and
/// the start of the next are the same half step (METHODS section 3).
///
/// It is taken at a few times as values that know neither place nor heading: the root's height, tilt and moves from time to time, and the
/// rotations of all other joints, each by its weight. Jacobians of these by the whitened latents, at the mean of each mixture component.
struct SharedMargin {
  std::vector<Eigen::MatrixXd> end;    // (values x D) of the step before, by the source's components
  std::vector<Eigen::MatrixXd> start;  // (values x E) of the step after, by the target's components

  bool empty() const { return end.empty(); }
};

/// @param means  rotations of the style of both. @param channel_weights  (channels) PoseLayout::ChannelWeights, which makes metres and radians compare.
SharedMargin FindSharedMargin(const MotionPrimitive& from, const MotionPrimitive& to, const PoseLayout& layout, const MeanRotations& means,
                              const Eigen::VectorXd& channel_weights);

/// What a step of whitened value w says of the one after it by this motion alone: A w is the mean of w' ~ N(0, I) given that
///   start w' = end w + noise of the given variance,
/// A = (S^T S + noise I)^-1 S^T E, S of `start` (values x E), E of `end` (values x D).
class SharedMarginMap {
 public:
  SharedMarginMap(const Eigen::MatrixXd& end, const Eigen::MatrixXd& start);
  /// A. @param noise_variance  > 0, in the squared unit of the values. @return (E x D).
  Eigen::MatrixXd WithNoise(double noise_variance) const;

 private:
  Eigen::MatrixXd information_, shared_;  // S^T S, S^T E
};

}  // namespace morphograph
