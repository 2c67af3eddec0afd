#include "synthesis/control/walk_state.h"

#include <algorithm>
#include <cmath>

#include "datasets/forward_kinematics.h"

namespace morphograph {

bool SteeredWalk::all_met() const {
  return std::all_of(outcomes.begin(), outcomes.end(), [](const ControlOutcome& outcome) { return outcome.met; });
}

double WalkState::FirstHeading() const {
  return begins_inside() ? kinematics[0]->Root({true, 0}, latents[0], places[0]).value[2] : places[0][kPlaceHeading];
}

std::optional<size_t> WalkState::LastKeyframe() const {
  if (stops()) return steps.size();
  if (problem.guide.steps) return std::min(steps.size(), static_cast<size_t>(*problem.guide.steps));
  return std::nullopt;
}

double WalkState::EndTime() const { return LastKeyframe() ? places[*LastKeyframe()][kPlaceTime] : (frames - 1) / rate(); }

size_t WalkState::StepAt(double time_s) const {
  size_t k = 0;
  while (k + 1 < steps.size() && places[k + 1][kPlaceTime] <= time_s) ++k;
  return k;
}

WalkState::Moment WalkState::MomentOfTime(double time_s) const {
  const int frame = std::clamp(static_cast<int>(std::lround(time_s * rate())), 0, frames - 1);
  return {StepAt(frame / rate()), {true, frame / rate()}, frame};
}

WalkState::Moment WalkState::MomentOf(const ControlMoment& moment) const {
  if (moment.time_s) return MomentOfTime(*moment.time_s);
  const auto keyframe = static_cast<size_t>(std::max(0, *moment.keyframe));
  const size_t step = std::min(keyframe, steps.size() - 1);
  const double phase = keyframe > step ? 1 : 0;
  const double time = places[std::min(keyframe, steps.size())][kPlaceTime];
  return {step, {false, phase}, std::clamp(static_cast<int>(std::lround(time * rate())), 0, frames - 1)};
}

std::optional<Eigen::Vector3d> WalkState::MeasuredJoint(int frame, int joint) const {
  if (!has_clip()) return std::nullopt;
  return ForwardKinematics(made.clip, frame).positions.col(joint);
}

Eigen::Vector3d WalkState::MeasuredRoot(int frame) const {
  return {made.clip.root_positions()(0, frame), made.clip.root_positions()(2, frame), HeadingRad(made.clip, frame)};
}

}  // namespace morphograph
