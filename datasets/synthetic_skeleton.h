#pragma once

#include <memory>

#include "datasets/skeleton.h"

namespace morphograph {

/// A generic humanoid of 19 joints, 3 rotations each (root 6 channels), order Z Y X, T-pose at rest, facing +Z, left on +X.
///
/// Segment lengths are fractions of stature (anthropometric table in Winter, "Biomechanics and Motor Control of Human
/// Movement", 4.1), rounded. The soles are the plane y = 0 of a standing figure: `SyntheticFoot` tells where they lie
/// below ankle and ball.
///
/// @param stature_m  standing height, (0.5, 3).
/// @throws std::invalid_argument outside of that.
std::shared_ptr<const Skeleton> SyntheticSkeleton(double stature_m = 1.75);

/// Foot of a synthetic skeleton, flat on the floor: lengths of its side view, metres.
struct SyntheticFoot {
  explicit SyntheticFoot(double stature_m);
  double ankle_height_m;
  double ball_height_m;
  double ball_ahead_m;  // ball ahead of the ankle
  double heel_behind_m;  // heel's contact point behind the ankle, on the sole
  double toe_length_m;  // ball to tip
  double tip_height_m;
};

}  // namespace morphograph
