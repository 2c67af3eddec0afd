#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/training_steps.h"
#include "primitives/motion_primitive.h"
#include "primitives/pose_layout.h"
#include "primitives/step_vector.h"
#include "primitives/time_warp.h"

namespace morphograph {

/// What the feet did over one captured step, on its class's timeline: as ContactProfile, but 1 where a part is planted and 0 where it is
/// not in place of a chance, and heights and velocities whether it is planted or not.
ContactProfile MeasureStepContacts(const PreparedClip& clip, const PoseLayout& layout, const StepSpan& span, const TimeWarp& warp);

/// Means over steps: heights and velocities of those in which a part is planted at that time, or of all where it never is.
ContactProfile MeanContacts(const std::vector<ContactProfile>& steps);

/// What of the steps' planted feet follows from their latents, as MotionPrimitive::contact_map has it: ridge regression of the deviations
/// from the mean, 0 where a part is not planted. So where few steps are planted, as at landing and lifting, a map says less than those few
/// alone would: about their share of it. Heights and velocities of each part of the feet have a ridge of their own, the one that predicts clips best
/// which it has not seen; those that none predicts better than the mean are zero.
///
/// @param latents  (components x steps). @param clips  per step the captured clip that it comes from; copies come from the same.
/// @return (deviations x components), see MotionPrimitive.
Eigen::MatrixXf FitContactMap(const std::vector<ContactProfile>& steps, const ContactProfile& mean, const Eigen::MatrixXd& latents,
                              const std::vector<int>& clips);

}  // namespace morphograph
