#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "primitives/pose_layout.h"

namespace morphograph {

struct TrainingSet;

/// A captured clip of RecordedMotion: columns [first, first + frames).
struct RecordedClip {
  std::string name;
  std::string style;
  double frame_rate_hz = 30;
  int first = 0;
  int frames = 0;
};

/// A step that training found in a captured clip; fractional frames of the clip.
struct RecordedStep {
  int clip = 0;
  double start_frame = 0;
  double end_frame = 0;
  bool left = false;  // the foot that lands at its end
};

/// The captured clips that a model was learned from, kept in its file: methods that find motion again by readings of sensors look it up frame by frame
/// (synthesis/sensors). Copies that training made are not kept. Rotations are good to 0.1 mrad, places to a micrometre.
struct RecordedMotion {
  std::vector<RecordedClip> clips;
  std::vector<RecordedStep> steps;  // of walking, clip after clip
  Eigen::MatrixXf roots;            // (3 x frames) of the moving root, m
  Eigen::MatrixXf rotations;        // (frames x 3 * active joints) rotation vectors, the moving root's in the world

  /// What does not fit, in words; empty where all does.
  std::string Problem(const PoseLayout& layout) const;
};

RecordedMotion RecordMotion(const TrainingSet& set);

/// The clips again, on the layout's skeleton. @param rest  rotations of the joints that are not active.
std::vector<MotionClip> RecordedClips(const RecordedMotion& motion, const PoseLayout& layout, const MeanRotations& rest);

}  // namespace morphograph
