#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"
#include "graph/walk_boundary.h"
#include "synthesis/control/control_terms.h"

namespace morphograph {

/// What can be asked for. Clip requests are held against the same bounds, so that what they let in can be made.
inline constexpr double kDefaultDuration_s = 5;  // of clips that say nothing of it
inline constexpr double kMaxDuration_s = 600;
inline constexpr int kMaxSteps = 1000;
inline constexpr double kMinFrameRate_hz = 1;
inline constexpr double kMaxFrameRate_hz = 240;
inline constexpr double kMaxStartDistance_m = 10'000;  // past this, 6 decimals of a file no longer hold the pose well

/// Where a clip begins: floor position (x, z) in metres; heading in radians, 0 along +Z, pi/2 along +X.
struct StartPose {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double heading_rad = 0;
};

/// Which parts of the start pose a request fixes. With a path or a goal, what it leaves open begins on the path, along it.
struct StartGiven {
  bool position = false;
  bool heading = false;
};

/// From about that time on the clip shows another action.
struct ActionFrom {
  double at_s = 0;
  std::string action;
};

/// What to synthesise. Either `duration_s` or `steps`; neither means as long as a path or a goal takes, and 5 s without them. A clip
/// that does not end inside the walk has as many steps as bring it nearest to its duration.
struct SynthesisRequest {
  std::uint64_t seed = 0;
  std::optional<std::string> action;  // any of the graph's actions; its own when empty
  /// Changes of action, in time order, each to another action than before. Such a clip has a duration and no control terms.
  std::vector<ActionFrom> changes = {};
  std::optional<std::string> style;   // any of that action's styles; drawn by the seed when empty
  std::optional<double> duration_s;   // (0, kMaxDuration_s]
  std::optional<int> steps;           // [1, kMaxSteps]
  StartPose start;
  StartGiven start_given;
  WalkBoundary start_from = WalkBoundary::kWalking;  // what the clip begins out of
  WalkBoundary end = WalkBoundary::kWalking;         // what it ends in
  ControlTerms control;
  std::optional<double> frame_rate_hz;  // [kMinFrameRate_hz, kMaxFrameRate_hz]; the model's own when empty

  /// What is wrong with the numbers, if anything: the field's name and the reason.
  std::optional<std::pair<std::string, std::string>> FirstProblem() const;
};

/// What a clip shows from a frame on.
struct ActionSpan {
  std::string action;
  int from = 0;
};

/// One step of the walk over the graph; frames [from, to] of the clip.
struct StepReport {
  std::string primitive;  // or the made step of a change
  int from = 0;
  int to = 0;
  double log_likelihood = 0;
};

/// A planted interval of one foot; position (x, z) of the ball of the foot.
struct PlantedFoot {
  ContactInterval interval;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

/// Quality of a clip as the report gives it. Definitions: METHODS section 6.
struct ClipQuality {
  double contact_distance_m = 0;   // mean height error of the planted feet over stance
  double foot_skate_cm_s = 0;
  double penetration_m = 0;        // deepest point below the ground, >= 0
  double naturalness = 0;          // Var D(F_i, F_i+1), Du Eq. 4.5-4.6
  std::optional<double> log_likelihood;  // of synthesised clips, under the model
};

struct SynthesisReport {
  std::uint64_t seed = 0;
  std::string model_name;
  std::string model_hash;
  std::string action;  // the first, where it changes
  std::vector<ActionSpan> actions;  // of a clip that changes its action: each from the made step that leads into it
  std::string style;
  double duration_s = 0;
  int frames = 0;
  std::vector<StepReport> steps;
  std::vector<PlantedFoot> contacts;
  std::vector<Eigen::Vector2d> path_m;  // root on the floor (x, z), one a frame
  std::shared_ptr<const SensorGuide> sensors = {};  // of clips that readings steered
  std::vector<ControlOutcome> constraints;  // path, goal and speed first, then as they were asked for
  ClipQuality quality;
};

struct SynthesisResult {
  MotionClip clip;
  SynthesisReport report;
};

}  // namespace morphograph
