#include "synthesis/control/swing_range.h"

#include <algorithm>
#include <cmath>

#include "datasets/leg_ik.h"
#include "primitives/time_warp.h"

namespace morphograph {
namespace {

constexpr double kFirstSwingPhase = 0.1, kSwingSpan = 0.1;  // from where the foot is lifted to where it lands
constexpr double kOneOfHundred = 2.326;                     // normal deviations

}  // namespace

SwingState SwingOf(const StepKinematics& step, const JointChain& ball, const Eigen::VectorXd& w) {
  const StepModel::Map& timing = step.model().timing();
  const Eigen::VectorXd values = timing.offset + timing.by_latent * w;
  const TimeWarp warp = TimeWarp::FromLogSlopes(values.tail(kWarpKnots));
  const double duration = std::exp(values[0]);
  struct At {
    Eigen::Vector3d position_m;
    Eigen::MatrixXd by_latent;
    double time_s = 0;
    Eigen::RowVectorXd time_by_latent;
  };
  const auto at = [&](int i) {
    const double phase = kFirstSwingPhase + kSwingSpan * i;
    PointState joint = step.Joint(ball, {false, phase}, w, KeyframePlace::Zero());
    return At{joint.position_m, std::move(joint.position_by_latent), duration * warp(phase),
              duration * (warp(phase) * timing.by_latent.row(0) + warp.Gradient(phase).transpose() * timing.by_latent.bottomRows(kWarpKnots))};
  };
  SwingState swing{Eigen::VectorXd(kSwingSpans), Eigen::VectorXd(kSwingSpans), Eigen::MatrixXd(kSwingSpans, w.size()), Eigen::MatrixXd(kSwingSpans, w.size())};
  At before = at(0);
  for (int i = 0; i < kSwingSpans; ++i) {
    At now = at(i + 1);
    const Eigen::Vector3d moved = now.position_m - before.position_m;
    const double way = std::max(moved.norm(), 1e-9), time = now.time_s - before.time_s;
    swing.speed_m_s[i] = way / time;
    swing.speed_by_latent.row(i) = (moved.transpose() / way * (now.by_latent - before.by_latent) - way / time * (now.time_by_latent - before.time_by_latent)) / time;
    swing.height_m[i] = before.position_m.y();
    swing.height_by_latent.row(i) = before.by_latent.row(1);
    before = std::move(now);
  }
  return swing;
}

SwingRange SwingRangeOf(const StepKinematics& step, const JointChain& ball) {
  const SwingState mean = SwingOf(step, ball, Eigen::VectorXd::Zero(step.dimension()));
  SwingRange range;
  const auto raise = [](double value, double deviation, double* bound, double* its_deviation) {
    if (value + kOneOfHundred * deviation <= *bound) return;
    *bound = value + kOneOfHundred * deviation;
    *its_deviation = deviation;
  };
  for (Eigen::Index i = 0; i < kSwingSpans; ++i) {
    raise(mean.speed_m_s[i], mean.speed_by_latent.row(i).norm(), &range.speed_m_s, &range.speed_deviation_m_s);
    raise(mean.height_m[i], mean.height_by_latent.row(i).norm(), &range.height_m, &range.height_deviation_m);
  }
  return range;
}

ClipSwing SwingInClip(const MotionClip& clip, Foot foot, int from, int to) {
  const LegIk leg(clip.skeleton(), foot);
  ClipSwing swing;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (int f = from; f <= to; ++f) {
    const Eigen::Vector3d ball = leg.Place(clip.root_positions().col(f), clip.rotations(f)).toe_m;
    swing.height_m = std::max(swing.height_m, ball.y());
    if (f > from) swing.speed_m_s = std::max(swing.speed_m_s, (ball - before).norm() * clip.frame_rate_hz());
    before = ball;
  }
  return swing;
}

}  // namespace morphograph
