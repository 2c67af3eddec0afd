#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "datasets/contact_detector.h"
#include "datasets/motion_clip.h"
#include "synthesis/ground_plane.h"

namespace morphograph {

/// Every measure of the evaluation is taken at this rate (METHODS section 6).
inline constexpr double kEvaluationRateHz = 30;

/// What the measures need of a clip, worked out once: the clip at 30 fps, its joints in the world, its
/// contacts, and the plane that they lie on, all found from the clip itself.
struct EvaluationMotion {
  std::shared_ptr<const Skeleton> skeleton;
  std::vector<Eigen::Matrix3Xd> joint_positions;  // (3 x joints) a frame, metres
  ContactTrack contacts;
  GroundPlane ground;

  int frame_count() const { return static_cast<int>(joint_positions.size()); }
};

/// Resamples to 30 fps where the clip has another rate.
/// @throws std::invalid_argument when leg roles are missing, fewer than 2 frames are left at 30 fps, or a
/// joint is not finite.
EvaluationMotion PrepareEvaluation(const MotionClip& clip);

}  // namespace morphograph
