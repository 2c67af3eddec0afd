#include "primitives/step_vector.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "primitives/cubic_resample.h"
#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

// Relative importance of timing, in the unit of the pose channels (metres of all measured joints).
constexpr double kDurationWeight = 2.0;
constexpr double kWarpWeight = 0.25;

// The step's own frame: where its root stands on the floor at a fractional frame and which way it faces.
struct FloorFrame {
  Eigen::Vector3d origin;  // y = 0
  double heading_rad;
};

FloorFrame FloorFrameAt(const MotionClip& clip, const PoseLayout& layout, double frame) {
  const int root = clip.skeleton().moving_root();
  const int low = std::clamp(static_cast<int>(std::floor(frame)), 0, std::max(0, clip.frame_count() - 2));
  const int high = std::min(low + 1, clip.frame_count() - 1);
  const double t = frame - low;
  FloorFrame result;
  result.origin = (1 - t) * clip.root_positions().col(low) + t * clip.root_positions().col(high);
  result.origin.y() = 0;
  const double from = layout.HeadingOf(clip.rotation(low, root));
  const double turned = std::remainder(layout.HeadingOf(clip.rotation(high, root)) - from, 2 * M_PI);
  result.heading_rad = from + t * turned;
  return result;
}

}  // namespace

bool HasMargins(const MotionClip& clip, const StepSpan& span) {
  return span.frames() > 0 && span.FrameAt(-kPhaseMargin) >= 0 && span.FrameAt(1 + kPhaseMargin) <= clip.frame_count() - 1;
}

StepSampler::StepSampler(const MotionClip& clip, const PoseLayout& layout, const MeanRotations& means, const StepSpan& span)
    : span_(span), frame_rate_hz_(clip.frame_rate_hz()) {
  if (!(span.frames() > 0) || span.start_frame < 0 || span.end_frame > clip.frame_count() - 1) {
    throw std::invalid_argument("StepSampler: the step does not lie inside the clip");
  }
  // A spline reaches a little beyond the frames that it is asked for.
  const double reach = span.frames() * (kPhaseMargin + 0.25) + 8;
  first_frame_ = std::max(0, static_cast<int>(std::floor(span.start_frame - reach)));
  const int last = std::min(clip.frame_count() - 1, static_cast<int>(std::ceil(span.end_frame + reach)));
  const FloorFrame frame = FloorFrameAt(clip, layout, span.start_frame);
  const Eigen::Quaterniond step_from_world = Yaw(-frame.heading_rad);
  const auto& joints = layout.active_joints();
  values_.resize(layout.channels(), last - first_frame_ + 1);
  for (int f = first_frame_; f <= last; ++f) {
    const auto column = f - first_frame_;
    values_.block<3, 1>(0, column) = step_from_world * (clip.root_positions().col(f) - frame.origin);
    for (size_t i = 0; i < joints.size(); ++i) {
      const Eigen::Quaterniond& local = clip.rotation(f, joints[i]);
      const Eigen::Index row = 3 + 3 * static_cast<Eigen::Index>(i);
      Eigen::Vector3d previous = Eigen::Vector3d::Zero();
      if (column > 0) previous = values_.block<3, 1>(row, column - 1);
      values_.block<3, 1>(row, column) =
          layout.ChannelsOf(i, means[joints[i]], i == 0 ? step_from_world * local : local, previous);
    }
  }
}

Eigen::MatrixXd StepSampler::PosesAt(const Eigen::VectorXd& frames) const {
  return ResampleCubic(values_, (frames.array() - first_frame_).matrix());
}

Eigen::MatrixXd StepSampler::Poses(const TimeWarp& warp) const {
  Eigen::VectorXd frames(kPhaseSamples);
  for (int i = 0; i < kPhaseSamples; ++i) frames[i] = span_.FrameAt(warp(PhaseOfSample(i)));
  return PosesAt(frames);
}

Eigen::VectorXd StepSampler::Vector(const TimeWarp& warp) const {
  const Eigen::MatrixXd poses = Poses(warp);
  Eigen::VectorXd vector(poses.size() + kTimingValues);
  vector.head(poses.size()) = poses.reshaped();
  vector[poses.size()] = std::log(duration_s());
  vector.tail(kWarpKnots) = warp.log_slopes();
  return vector;
}

Eigen::VectorXd StepWeights(const Eigen::VectorXd& channel_weights) {
  const double share = 1 / std::sqrt(static_cast<double>(kPhaseSamples));
  Eigen::VectorXd weights(channel_weights.size() * kPhaseSamples + kTimingValues);
  weights.head(channel_weights.size() * kPhaseSamples) = share * channel_weights.replicate(kPhaseSamples, 1);
  weights[channel_weights.size() * kPhaseSamples] = kDurationWeight;
  weights.tail(kWarpKnots).setConstant(kWarpWeight);
  return weights;
}

MeanRotations MeanOverSteps(const std::vector<StepOfClip>& steps, const PoseLayout& layout) {
  // A handful of frames of each step says as much of the mean as all of them.
  constexpr int kFramesPerStep = 6;
  const int joints = layout.skeleton().joint_count();
  std::vector<std::vector<Eigen::Quaterniond>> seen(joints);
  for (const StepOfClip& step : steps) {
    const Eigen::Quaterniond step_from_world =
        Yaw(-FloorFrameAt(*step.clip, layout, step.span.start_frame).heading_rad);
    for (int i = 0; i < kFramesPerStep; ++i) {
      const int frame = std::clamp(static_cast<int>(std::lround(step.span.FrameAt(static_cast<double>(i) / kFramesPerStep))), 0,
                                   step.clip->frame_count() - 1);
      for (int j = 0; j < joints; ++j) {
        const Eigen::Quaterniond& local = step.clip->rotation(frame, j);
        seen[j].push_back(j == layout.skeleton().moving_root() ? step_from_world * local : local);
      }
    }
  }
  MeanRotations means(joints, Eigen::Quaterniond::Identity());
  for (int j = 0; j < joints; ++j) {
    if (!seen[j].empty()) means[j] = GeodesicMean(seen[j]);
  }
  return means;
}

}  // namespace morphograph
