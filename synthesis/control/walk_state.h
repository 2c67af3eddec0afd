#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "synthesis/control/control_measure.h"
#include "synthesis/control/swing_range.h"
#include "synthesis/evaluation.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {

/// A walk that was steered, and its clip.
struct SteeredWalk {
  DrawnWalk walk;
  StartPose start;
  MotionClip clip;
  ClipEvaluation evaluation;
  std::vector<double> keyframe_times_s;
  std::vector<ControlOutcome> outcomes;
  double swing_excess = 0;  // of the swing that is farthest beyond what swings of its kind keep to (SwingRange), in parts of that; 0 where all are within

  bool all_met() const;
};

/// A walk while it is being optimised: unknowns, what is known of its steps, and the clip that the last solution made.
struct WalkState {
  const ControlProblem& problem;
  std::vector<WalkStep> steps;  // as planned
  std::vector<std::shared_ptr<const StepKinematics>> kinematics;
  std::vector<Eigen::VectorXd> latents;  // unknown: whitened, of each step
  std::vector<KeyframePlace> places;     // unknown: where each step begins, and where the last ends
  std::vector<double> along_m;           // of the places, on the guide's path
  int frames = 0;                        // of the clip
  Eigen::MatrixXd readings;              // that the walk is held to
  std::vector<std::optional<SwingRange>> swings = {};  // of the steps, where a swing was beyond them and is held to them since
  SteeredWalk made;                      // no frames before there was a solution

  // A moment of the clip: the step that it lies in, and the frame.
  struct Moment {
    size_t step;
    StepMoment moment;
    int frame;
  };

  double rate() const { return problem.frame_rate_hz; }
  bool stops() const { return problem.guide.to != WalkBoundary::kWalking; }
  bool has_clip() const { return made.clip.frame_count() > 0; }
  /// Whether the clip begins inside of its first step, not with it.
  bool begins_inside() const { return !problem.guide.given.empty(); }
  /// Heading of the root at the clip's start.
  double FirstHeading() const;
  /// The key frame that a clip ends at, or, where the walk stops, after; none where a time or a place on the path ends it.
  std::optional<size_t> LastKeyframe() const;
  double EndTime() const;  // s
  size_t StepAt(double time_s) const;
  Moment MomentOfTime(double time_s) const;
  Moment MomentOf(const ControlMoment& moment) const;

  // On the clip that was made:
  std::optional<Eigen::Vector3d> MeasuredJoint(int frame, int joint) const;  // none before there is a clip
  Eigen::Vector3d MeasuredRoot(int frame) const;                             // x, z, heading
};

}  // namespace morphograph
