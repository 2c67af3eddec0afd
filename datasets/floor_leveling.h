#pragma once

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"

namespace morphograph {

struct FloorLevelingOptions {
  /// Height above the floor y = 0 at which the ball joint of a standing foot shall lie: what the recordings at hand show on
  /// their flat floors.
  double ball_height_m = 0.042;
  /// A floor is left as it is while its stances rise or fall by less than this over the clip and lie within this of
  /// `ball_height_m`: it is then as level as feet can tell, and shoes differ.
  double tolerance_m = 0.012;
};

/// What was wrong with the floor and what was done.
struct FloorLevelingReport {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  // of the floor taken out, along x and z
  double shift_m = 0;                                // added to every height
  bool uneven = false;                               // no plane holds the stances: not rotated
};

/// The clip on a level floor y = 0, turned and shifted as a whole; bones and joint angles stay as they are.
///
/// The floor is the plane of `contacts`. Where no plane holds all stances (steps, blocks), the clip is shifted at most.
/// A straight walk shows no slope across its path; none is taken out then.
/// @throws std::invalid_argument when leg roles are missing or the clip has no frame.
MotionClip LevelFloor(const MotionClip& clip, const ContactTrack& contacts, const FloorLevelingOptions& options = {},
                      FloorLevelingReport* report = nullptr);
MotionClip LevelFloor(const MotionClip& clip, const FloorLevelingOptions& options = {}, FloorLevelingReport* report = nullptr);

}  // namespace morphograph
