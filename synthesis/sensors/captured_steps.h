#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "datasets/placements.h"
#include "graph/recorded_motion.h"
#include "primitives/pose_layout.h"

namespace morphograph {

/// Rate at which readings and captured steps are compared.
inline constexpr double kSensorRate_hz = 30;

/// Captured steps that end with the landing of one foot, a column each: their poses and what sensors on the body would read, both on the canonical
/// timeline (kPhaseSamples, margins included; time runs evenly).
struct StepBank {
  Eigen::MatrixXf poses;          // (channels * samples x steps), PoseLayout channels about CapturedSteps::means()
  Eigen::MatrixXf readings;       // (3 * sensors * samples x steps), m/s^2
  Eigen::VectorXf log_durations;  // of seconds
  std::vector<int> styles;        // indices into CapturedSteps::styles()

  Eigen::Index size() const { return poses.cols(); }
};

/// The steps of recordings, mirrored copies included, with the readings of sensors at given places. Immutable.
class CapturedSteps {
 public:
  /// @param clips, steps  as RecordedMotion has them; steps whose margins reach beyond their clip are left out.
  /// @param tempos  copies of every step that are so many times as fast, beside the step itself.
  /// @throws std::invalid_argument where no step is left, or a sensor's joint does not exist.
  CapturedSteps(const std::vector<MotionClip>& clips, const std::vector<RecordedStep>& steps, const PoseLayout& layout,
                std::vector<Placement> sensors, bool mirrored = true, int jobs = 1, const std::vector<double>& tempos = {});

  const PoseLayout& layout() const { return layout_; }
  const MeanRotations& means() const { return means_; }  // over all steps, whatever their style
  const std::vector<std::string>& styles() const { return styles_; }
  const std::vector<Placement>& sensors() const { return sensors_; }
  const StepBank& landing(bool left) const { return banks_[left ? 0 : 1]; }

 private:
  PoseLayout layout_;
  std::vector<Placement> sensors_;
  MeanRotations means_;
  std::vector<std::string> styles_;
  StepBank banks_[2];
};

}  // namespace morphograph
