#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/motion_clip.h"
#include "primitives/motion_primitive.h"
#include "primitives/pose_layout.h"
#include "primitives/time_warp.h"

namespace morphograph {

/// Where a step lies in a clip; fractional frames of the clip.
struct StepSpan {
  double start_frame = 0;
  double end_frame = 0;

  double frames() const { return end_frame - start_frame; }
  double FrameAt(double source_phase) const { return start_frame + source_phase * frames(); }
};

/// True where the step and its margins lie inside the clip.
bool HasMargins(const MotionClip& clip, const StepSpan& span);

/// Poses of a clip around a step in the step's own frame (origin on the floor under the root at the first key frame, +Z along the
/// heading there), as PoseLayout channels, by cubic spline at any fractional frame.
class StepSampler {
 public:
  /// @throws std::invalid_argument when the step has no length or lies outside the clip.
  StepSampler(const MotionClip& clip, const PoseLayout& layout, const MeanRotations& means, const StepSpan& span);

  const StepSpan& span() const { return span_; }
  double duration_s() const { return span_.frames() / frame_rate_hz_; }

  /// Poses at fractional frames of the clip. (channels x frames.size())
  Eigen::MatrixXd PosesAt(const Eigen::VectorXd& frames) const;
  /// Poses on the canonical timeline under a warp from canonical to source phase. (channels x kPhaseSamples)
  Eigen::MatrixXd Poses(const TimeWarp& warp) const;
  /// The step's vector (see StepReduction): poses under the warp, then timing.
  Eigen::VectorXd Vector(const TimeWarp& warp) const;

 private:
  StepSpan span_;
  double frame_rate_hz_;
  int first_frame_;         // of the columns of `values_`
  Eigen::MatrixXd values_;  // (channels x frames around the step)
};

/// Weights of a step vector's values, to be applied before squaring.
/// @param channel_weights  PoseLayout::ChannelWeights.
Eigen::VectorXd StepWeights(const Eigen::VectorXd& channel_weights);

/// One step to take into a mean.
struct StepOfClip {
  const MotionClip* clip = nullptr;
  StepSpan span;
};

/// Mean rotation of every joint over steps: each joint's geodesic mean; the root's in the steps' own frames.
MeanRotations MeanOverSteps(const std::vector<StepOfClip>& steps, const PoseLayout& layout);

}  // namespace morphograph
