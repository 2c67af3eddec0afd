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

/// What the feet of a class's steps do, as MotionPrimitive tells it by the latent.
struct StepContacts {
  ContactProfile at_zero;  // where the latent is 0
  Eigen::MatrixXf map;     // (kContactRows * kPhaseSamples x components)
};

/// Linear regressions with a ridge, part by part of the feet and sample by sample: the chance over all steps; height and velocity over those
/// in which the part is planted then, as feet in the air say nothing of how feet stand. Of each part, chance, height and velocities have a
/// ridge each, the one that predicts clips best which it has not seen; what none predicts better than the mean is that.
///
/// @param latents  (components x steps). @param clips  per step the captured clip that it comes from; copies come from the same.
/// @throws std::invalid_argument when sizes do not fit, or there is no step.
StepContacts FitStepContacts(const std::vector<ContactProfile>& steps, const Eigen::MatrixXd& latents, const std::vector<int>& clips);

}  // namespace morphograph
