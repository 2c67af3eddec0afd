#include "primitives/step_blend.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/leg_ik.h"
#include "primitives/time_warp.h"

namespace morphograph {
namespace {

constexpr int kFirstLanding = 4, kLastLanding = 20;  // samples of phase 0 and 1, see PhaseOfSample

double ShareOfLast(double phase) {
  const double t = std::clamp(phase, 0.0, 1.0);
  return t * t * t * (t * (6 * t - 15) + 10);
}

// Where the ball of the standing foot is, in the step's own frame: its mean place while it is planted in both steps.
Eigen::Vector3d StandingPlace(const PoseLayout& layout, const MeanRotations& means, const LegIk& leg, const Eigen::MatrixXd& poses,
                              const Eigen::VectorXd& chances) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<Eigen::Quaterniond> rotations = means;
  for (int i = 0; i < kPhaseSamples; ++i) {
    if (chances[i] == 0) continue;
    for (size_t n = 0; n < layout.active_joints().size(); ++n) {
      const size_t joint = static_cast<size_t>(layout.active_joints()[n]);
      rotations[joint] = layout.RotationOf(n, means[joint], poses.block<3, 1>(3 + 3 * static_cast<Eigen::Index>(n), i));
    }
    sum += chances[i] * leg.Place(poses.block<3, 1>(0, i), rotations.data()).toe_m;
  }
  return sum / chances.sum();
}

}  // namespace

StepWithContacts BlendSteps(const PoseLayout& layout, const MeanRotations& means, Foot stance, const StepWithContacts& first,
                            const StepWithContacts& last) {
  if (first.shape.poses.rows() != layout.channels() || last.shape.poses.rows() != layout.channels()) {
    throw std::invalid_argument("BlendSteps: steps do not fit the pose layout");
  }
  StepWithContacts made;
  Eigen::VectorXd share(kPhaseSamples), standing(kPhaseSamples);
  const int ball = stance == Foot::kLeft ? 1 : 3;
  for (int i = 0; i < kPhaseSamples; ++i) {
    share[i] = ShareOfLast(PhaseOfSample(i));
    const bool inside = i >= kFirstLanding && i <= kLastLanding;
    standing[i] = inside ? first.contacts(ball, i) * last.contacts(ball, i) : 0;
  }
  if (!(standing.sum() > 0)) standing[kFirstLanding] = 1;  // balls that never stand at the same phase: where the foot lands
  const LegIk leg(layout.skeleton(), stance);
  const Eigen::Vector3d from = StandingPlace(layout, means, leg, first.shape.poses, standing);
  const Eigen::Vector3d to = StandingPlace(layout, means, leg, last.shape.poses, standing);
  const Eigen::Vector3d shift(from.x() - to.x(), 0, from.z() - to.z());

  made.shape.poses.resizeLike(first.shape.poses);
  for (int i = 0; i < kPhaseSamples; ++i) {
    Eigen::VectorXd there = last.shape.poses.col(i);
    there.head<3>() += shift;
    made.shape.poses.col(i) = (1 - share[i]) * first.shape.poses.col(i) + share[i] * there;
    made.contacts.col(i) = (1 - share[i]) * first.contacts.col(i) + share[i] * last.contacts.col(i);
  }

  // Seconds a phase: the duration times the slope of the warp.
  Eigen::VectorXd tempo(kWarpKnots);
  const auto tempo_of = [](const StepShape& step) -> Eigen::VectorXd {
    return TimeWarp::FromLogSlopes(step.log_slopes).log_slopes().array() + std::log(step.duration_s);
  };
  const Eigen::VectorXd tempo_first = tempo_of(first.shape), tempo_last = tempo_of(last.shape);
  for (int k = 0; k < kWarpKnots; ++k) {
    const double s = ShareOfLast(static_cast<double>(k) / (kWarpKnots - 1));
    tempo[k] = (1 - s) * tempo_first[k] + s * tempo_last[k];
  }
  made.shape.log_slopes = TimeWarp::FromLogSlopes(tempo).log_slopes();
  made.shape.duration_s = std::exp(tempo[0] - made.shape.log_slopes[0]);
  return made;
}

double PoseDistance_m(const StepShape& a, const StepShape& b, const Eigen::VectorXd& channel_weights) {
  double sum = 0;
  for (int i = kFirstLanding; i <= kLastLanding; ++i) {
    const auto apart = channel_weights.array() * (a.poses.col(i) - b.poses.col(i)).array();
    sum += apart.square().sum() - apart[0] * apart[0] - apart[2] * apart[2];
  }
  // A metre of the root weighs as much as a metre of every joint that counts.
  return std::sqrt(std::max(0.0, sum) / (kLastLanding - kFirstLanding + 1)) / channel_weights[1];
}

double StepSpeed_m_s(const StepShape& step) {
  const Eigen::VectorXd way = step.poses.col(kLastLanding) - step.poses.col(kFirstLanding);
  return std::hypot(way[0], way[2]) / step.duration_s;
}

double HardestAcceleration_m_s2(const StepShape& step, const Eigen::VectorXd& channel_weights) {
  const TimeWarp warp = TimeWarp::FromLogSlopes(step.log_slopes);
  const auto time_s = [&](int sample) { return step.duration_s * warp(PhaseOfSample(sample)); };
  double hardest = 0;
  for (int i = kFirstLanding; i <= kLastLanding; ++i) {
    const double before_s = time_s(i) - time_s(i - 1), after_s = time_s(i + 1) - time_s(i);
    const auto velocity_after = (step.poses.col(i + 1) - step.poses.col(i)) / after_s;
    const auto velocity_before = (step.poses.col(i) - step.poses.col(i - 1)) / before_s;
    const double changed = channel_weights.cwiseProduct(velocity_after - velocity_before).norm();
    hardest = std::max(hardest, changed / (0.5 * (before_s + after_s)));
  }
  return hardest / channel_weights[1];
}

}  // namespace morphograph
