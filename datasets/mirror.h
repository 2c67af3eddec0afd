#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// How the left and right half of a skeleton correspond.
///
/// `pairs[j]` is the joint opposite to j: itself on the midline, -1 for a joint that one side alone has (a prop in a hand). `turns[j]` (orthogonal, determinant -1) takes vectors from the
/// frame of the opposite joint to that of j: the reflection of body j, written in the two joints' own axes. Skeletons draw these axes
/// as they like: with the same axes on both sides it is diag(-1, 1, 1); where left bones run along +X and right ones
/// along -X, something else.
struct MirrorMap {
  std::vector<int> pairs;
  std::vector<Eigen::Matrix3d> turns;
};

/// Pairs joints by role, else by name (Left/Right, L/R as first or last letter), and finds each pair's axes from bone offsets and
/// from the clip itself: offsets leave the roll about a bone open, but over a clip left and right do much the same.
/// Where axes exchanged and turned over (a signed permutation) do for the bones, the best of these is taken.
/// @throws std::invalid_argument naming the joint where the two sides do not have the same hierarchy.
MirrorMap FindMirrorMap(const MotionClip& clip);

/// The clip as seen in a mirror in the plane x = 0: what the left did, the right does.
///
/// With R_j the world rotation of joint j, S = diag(-1, 1, 1) and B_j = turns[j], the opposite joint gets S R_j B_j, which
/// puts every mirrored joint where S says, as far as the bones of the two sides are equally long. Where leg bones differ, the legs are set by
/// inverse kinematics so that mirrored feet stand where mirrored feet stood. Joints without an opposite keep their local
/// rotation. `name` gets "_mirrored".
/// @throws std::invalid_argument when the map does not fit the skeleton.
MotionClip Mirrored(const MotionClip& clip, const MirrorMap& map);
MotionClip Mirrored(const MotionClip& clip);

}  // namespace morphograph
