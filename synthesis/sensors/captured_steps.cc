#include "synthesis/sensors/captured_steps.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/mirror.h"
#include "datasets/parallel_for.h"
#include "datasets/resample.h"
#include "datasets/virtual_sensors.h"
#include "primitives/cubic_resample.h"
#include "primitives/step_vector.h"

namespace morphograph {
namespace {

struct SourceStep {
  int clip = 0;
  StepSpan span;
  bool left = false;
};

// Steps enough for a mean.
constexpr std::size_t kStepsOfMean = 1000;

Eigen::VectorXd FramesOf(const StepSpan& span) {
  Eigen::VectorXd frames(kPhaseSamples);
  for (int i = 0; i < kPhaseSamples; ++i) frames[i] = span.FrameAt(PhaseOfSample(i));
  return frames;
}

}  // namespace

CapturedSteps::CapturedSteps(const std::vector<MotionClip>& recorded, const std::vector<RecordedStep>& recorded_steps, const PoseLayout& layout,
                             std::vector<Placement> sensors, bool mirrored, int jobs, const std::vector<double>& tempos)
    : layout_(layout), sensors_(std::move(sensors)) {
  const int sides = mirrored ? 2 : 1;
  std::vector<double> speeds = {1};
  speeds.insert(speeds.end(), tempos.begin(), tempos.end());
  const int copies = sides * static_cast<int>(speeds.size());
  std::vector<MotionClip> clips(recorded.size() * static_cast<std::size_t>(copies));
  std::vector<Eigen::MatrixXd> readings(clips.size());
  ParallelFor(jobs, static_cast<int>(recorded.size()), [&](int c) {
    const MotionClip& clip = recorded[static_cast<std::size_t>(c)];
    for (int copy = 0; copy < copies; ++copy) {
      const std::size_t place = static_cast<std::size_t>(c * copies + copy);
      const double speed = speeds[static_cast<std::size_t>(copy / sides)];
      const MotionClip side = copy % sides == 0 ? clip : Mirrored(clip);
      clips[place] = Resample(speed == 1 ? side : Retimed(side, clip.frame_rate_hz() * speed), kSensorRate_hz);
      if (clips[place].frame_count() >= 3) readings[place] = VirtualAccelerations(clips[place], sensors_, kSensorRate_hz).values;
    }
  });
  std::vector<SourceStep> steps;
  for (const RecordedStep& step : recorded_steps) {
    for (int copy = 0; copy < copies; ++copy) {
      const double scale = kSensorRate_hz / (recorded[static_cast<std::size_t>(step.clip)].frame_rate_hz() * speeds[static_cast<std::size_t>(copy / sides)]);
      const SourceStep source{step.clip * copies + copy, {step.start_frame * scale, step.end_frame * scale}, step.left != (copy % sides == 1)};
      if (HasMargins(clips[static_cast<std::size_t>(source.clip)], source.span)) steps.push_back(source);
    }
  }
  if (steps.empty()) throw std::invalid_argument("CapturedSteps: no step with margins in the recordings");

  std::vector<StepOfClip> of_mean;
  const std::size_t stride = 1 + steps.size() / kStepsOfMean;
  for (std::size_t s = 0; s < steps.size(); s += stride) of_mean.push_back({&clips[static_cast<std::size_t>(steps[s].clip)], steps[s].span});
  means_ = MeanOverSteps(of_mean, layout_);
  for (const MotionClip& clip : recorded) styles_.push_back(clip.style);
  std::sort(styles_.begin(), styles_.end());
  styles_.erase(std::unique(styles_.begin(), styles_.end()), styles_.end());

  std::vector<Eigen::Index> columns(steps.size());
  Eigen::Index counts[2] = {0, 0};
  for (std::size_t s = 0; s < steps.size(); ++s) columns[s] = counts[steps[s].left ? 0 : 1]++;
  for (int foot = 0; foot < 2; ++foot) {
    banks_[foot].poses.resize(layout_.channels() * kPhaseSamples, counts[foot]);
    banks_[foot].readings.resize(3 * static_cast<Eigen::Index>(sensors_.size()) * kPhaseSamples, counts[foot]);
    banks_[foot].log_durations.resize(counts[foot]);
    banks_[foot].styles.resize(static_cast<std::size_t>(counts[foot]));
  }
  ParallelFor(jobs, static_cast<int>(steps.size()), [&](int s) {
    const SourceStep& step = steps[static_cast<std::size_t>(s)];
    const MotionClip& clip = clips[static_cast<std::size_t>(step.clip)];
    const Eigen::VectorXd frames = FramesOf(step.span);
    const StepSampler sampler(clip, layout_, means_, step.span);
    StepBank& bank = banks_[step.left ? 0 : 1];
    const Eigen::Index column = columns[static_cast<std::size_t>(s)];
    bank.poses.col(column) = sampler.PosesAt(frames).reshaped().cast<float>();
    bank.readings.col(column) = ResampleCubic(readings[static_cast<std::size_t>(step.clip)], frames).reshaped().cast<float>();
    bank.log_durations[column] = static_cast<float>(std::log(sampler.duration_s()));
    bank.styles[static_cast<std::size_t>(column)] =
        static_cast<int>(std::lower_bound(styles_.begin(), styles_.end(), recorded[static_cast<std::size_t>(step.clip / copies)].style) - styles_.begin());
  });
}

}  // namespace morphograph
