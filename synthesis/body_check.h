#pragma once

#include "synthesis/evaluation_motion.h"

namespace morphograph {

/// What a body can never do; a synthesised clip is checked against it.
struct BodyCheck {
  double min_knee_flexion_deg = 0;  // of both knees; negative where a knee bends back
  double max_knee_flexion_deg = 0;
  double bone_length_error_m = 0;  // largest |distance to the parent - offset| over joints and frames
  double lowest_m = 0;             // lowest of heels, balls and ankles above the contact plane
};

/// Signed flexion of a knee, degrees: the angle from thigh to shank about the leg's own left axis, positive
/// when the ankle lies behind. The axis is the mean of the pelvis' left and the left of the foot, so that a
/// leg turned outwards is measured in its own plane, and a straight leg's bow to the side does not count.
/// @param pelvis_left  left hip joint minus right hip joint; need not be a unit vector.
double KneeFlexionDeg(const Eigen::Vector3d& hip, const Eigen::Vector3d& knee, const Eigen::Vector3d& ankle,
                      const Eigen::Vector3d& ball, const Eigen::Vector3d& pelvis_left);

/// @throws std::invalid_argument when leg roles are missing.
BodyCheck CheckBody(const EvaluationMotion& motion);

}  // namespace morphograph
