#pragma once

#include <memory>

#include "datasets/motion_clip.h"

namespace morphograph {

/// The motion of `clip` on another skeleton.
///
/// Skeletons with the same joint names, hierarchy and bone directions (within 20 degrees; several people of one
/// data set) exchange local rotations. Others exchange world rotations role by role, relative to the rest pose (all
/// rotations zero): limbs and spine so that the bones point where the source's point, whatever their rest
/// directions; pelvis, feet and toes as they turn away from rest, so that soles that lie flat stay flat. Spine joints
/// without a role are spread between their neighbours, other joints without one copy
/// the local rotation of a joint of the same name below a parent of the same name, or keep their rest pose. The root's path is
/// scaled by the ratio of the leg lengths about the world origin. Legs are then bent a little, so that feet go where the source's go and stand
/// as high (PlaceFeetAsIn): of bones of other lengths the same turns would put them elsewhere.
///
/// @throws std::invalid_argument when the skeletons differ and either lacks leg roles, or has a rest pose that is not
///   an upright figure with straight legs down and its left side on one hand (bnr's bones all point along X at rest).
MotionClip Retarget(const MotionClip& clip, const std::shared_ptr<const Skeleton>& target);

/// Whether Retarget would exchange local rotations as they are.
bool SameRestPose(const Skeleton& a, const Skeleton& b);

/// Whether both are one body: SameRestPose(), and joints that sit alike on their parents to the last digit. Where the root starts does not count, nor do the ends of
/// the last bones, at which no joint is.
bool SameBones(const Skeleton& a, const Skeleton& b);

}  // namespace morphograph
