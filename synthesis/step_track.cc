#include "synthesis/step_track.h"

#include <algorithm>
#include <cmath>

#include "primitives/cubic_resample.h"
#include "primitives/rotation_math.h"
#include "primitives/time_warp.h"

namespace morphograph {
namespace {

constexpr double kCrossFade_s = 2.5 / 30;
// Part of a step that its cross-fade may take: inside the margin of a quarter, with room for the increment to the next frame.
constexpr double kLargestCrossFade = 0.2;

}  // namespace

double CrossFadeHalfWidth(double frames_before, double frames_after, double frame_rate_hz) {
  return std::min(kCrossFade_s * frame_rate_hz, kLargestCrossFade * std::min(frames_before, frames_after));
}

double MarginBefore(const StepShape& shape) { return -TimeWarp::FromLogSlopes(shape.log_slopes)(-kPhaseMargin); }

double MarginAfter(const StepShape& shape) { return TimeWarp::FromLogSlopes(shape.log_slopes)(1 + kPhaseMargin) - 1; }

StepTrack LayOutStep(int style, const StepShape& shape, const ContactProfile& contacts, double start, double frame_rate_hz,
                     int first_frame, int last_frame) {
  static const UniformCubicSpline spline(kPhaseSamples);
  const double step_frames = shape.duration_s * frame_rate_hz;
  const TimeWarp warp = TimeWarp::FromLogSlopes(shape.log_slopes);
  const int frames = last_frame - first_frame + 1;
  Eigen::VectorXd positions(frames);
  for (int i = 0; i < frames; ++i) {
    const double source_phase = (first_frame + i - start) / step_frames;
    positions[i] = (warp.Inverse(source_phase) + kPhaseMargin) / kPhaseSpacing;
  }
  StepTrack track;
  track.style = style;
  track.start = start;
  track.end = start + step_frames;
  track.first_frame = first_frame;
  track.poses = spline.Interpolate(shape.poses, positions);
  track.contacts.resize(kContactRows, frames);
  for (int i = 0; i < frames; ++i) {
    const double position = std::clamp(positions[i], 0.0, kPhaseSamples - 1.001);
    const int sample = static_cast<int>(position);
    const double t = position - sample;
    track.contacts.col(i) = (1 - t) * contacts.col(sample) + t * contacts.col(sample + 1);
  }
  return track;
}

void ToLogMaps(const PoseLayout& layout, const MeanRotations& means, StepTrack* track) {
  if (layout.rotation_form() == RotationForm::kLogMap) return;
  for (size_t n = 0; n < layout.active_joints().size(); ++n) {
    const Eigen::Quaterniond& mean = means[layout.active_joints()[n]];
    for (int f = 0; f < track->frames(); ++f) {
      auto channels = track->poses.block<3, 1>(3 + 3 * static_cast<Eigen::Index>(n), f);
      channels = LogMapAbout(mean, layout.RotationOf(n, mean, channels));
    }
  }
}

}  // namespace morphograph
