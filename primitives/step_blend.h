#pragma once

#include "datasets/contact_detector.h"
#include "primitives/motion_primitive.h"
#include "primitives/pose_layout.h"

namespace morphograph {

/// A step with what is known of its feet.
struct StepWithContacts {
  StepShape shape;
  ContactProfile contacts = ContactProfile::Zero(kContactRows, kPhaseSamples);
};

/// Makes a step that begins as one step and ends as another, both of the same foot: a walking step that becomes a running one.
///
/// Phase by phase, with s rising from 0 at the first landing to 1 at the second (quintic, so that speed and acceleration at either end are
/// those of the step there; each margin is wholly of one step): joint rotations as log maps about the same means, the height of the root,
/// the logarithm of the time that a phase takes, and the contacts are (1 - s) of the one and s of the other. So is the place of the root
/// on the floor, seen from where the ball of the standing foot stands in each: a foot that stands in both stands in the made step.
/// @param means  that both steps' rotations are about. @param stance  the foot that has landed where the steps begin.
/// @throws std::invalid_argument when a step does not fit the layout.
StepWithContacts BlendSteps(const PoseLayout& layout, const MeanRotations& means, Foot stance, const StepWithContacts& first,
                            const StepWithContacts& last);

/// How far joints are apart in two steps at equal phases, seen from the root on the floor: metres, root mean square over the phases of the
/// step and over the joints that count.
/// @param channel_weights  PoseLayout::ChannelWeights.
double PoseDistance_m(const StepShape& a, const StepShape& b, const Eigen::VectorXd& channel_weights);

/// On the floor from the first landing to the second, over the duration.
double StepSpeed_m_s(const StepShape& step);

/// The hardest that the body is accelerated in a step: m/s^2, root mean square over the joints that count, the root's own motion with
/// them; the most of all phases.
/// @param channel_weights  PoseLayout::ChannelWeights.
double HardestAcceleration_m_s2(const StepShape& step, const Eigen::VectorXd& channel_weights);

}  // namespace morphograph
