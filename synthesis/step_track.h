#pragma once

#include <Eigen/Core>

#include "graph/motion_graph.h"

namespace morphograph {

/// A drawn step laid out on the clip's frames, its margins included. Times are in frames of the clip, fractional.
struct StepTrack {
  int style = 0;          // of the graph's styles
  double start = 0;       // time of the first key frame
  double end = 0;         // time of the second
  int first_frame = 0;    // of the columns below
  Eigen::MatrixXd poses;      // (channels x frames), in the step's own frame
  ContactProfile contacts;    // (kContactRows x frames)

  int frames() const { return static_cast<int>(poses.cols()); }
};

/// Half width of the cross-fade between two steps, in frames: about 83 ms (METHODS section 3), less where steps are so short that
/// their margins would not reach.
double CrossFadeHalfWidth(double frames_before, double frames_after, double frame_rate_hz);
/// In place of it where steps are cut without a cross-fade.
inline constexpr double kHardCutHalfWidth = 1e-9;

/// Margins of a step as parts of its duration: a quarter of the canonical timeline at the speed that the warp has at that end.
double MarginBefore(const StepShape& shape);
double MarginAfter(const StepShape& shape);

/// Lays out a step that starts at time `start` at the clip's frames [first_frame, last_frame].
/// Frames beyond the step's margins repeat the margin's last pose.
/// @param contacts  of the step, on the canonical timeline.
StepTrack LayOutStep(int style, const StepShape& shape, const ContactProfile& contacts, double start, double frame_rate_hz,
                     int first_frame, int last_frame);

/// Turns rotations of another form (see RotationForm) into log maps about the style's means, for those that follow.
void ToLogMaps(const PoseLayout& layout, const MeanRotations& means, StepTrack* track);

}  // namespace morphograph
