#pragma once

#include <Eigen/Core>

#include "datasets/contact_detector.h"
#include "synthesis/ground_plane.h"

namespace morphograph {

/// How well the feet of a clip keep to the ground; the same code for captured and synthesised clips.
struct ContactQuality {
  /// Mean over planted foot-frames of |height of the contact point above the contact plane| (Du 4.5.1,
  /// Table 4.4). The contact point of a planted foot is the lower of its heel and its ball. 0 when no foot is
  /// ever planted.
  double contact_distance_m = 0;
  int planted_foot_frames = 0;
  /// Mean over frames and both balls of v clamp(2 - 2^(h / 2.5 cm), 0, 1): v horizontal speed between two
  /// frames, h mean height above the contact plane in them (METHODS section 6).
  double foot_skate_cm_s = 0;
  /// The part of it that comes from balls planted in both frames; the rest is feet in the air that pass low over the floor.
  double planted_skate_cm_s = 0;
  /// Deepest point of heel and ball below the contact plane, >= 0.
  double penetration_m = 0;
  /// Per frame, mean over its planted feet; 0 where none is planted (Du Fig. 4.17). (frames)
  Eigen::VectorXd distance_m;
};

/// @param contacts  of a clip at `frame_rate_hz`; skate depends on the rate a little, the evaluation uses 30
/// fps.
/// @throws std::invalid_argument for fewer than 2 frames.
ContactQuality MeasureContacts(const ContactTrack& contacts, const GroundPlane& ground, double frame_rate_hz);

}  // namespace morphograph
