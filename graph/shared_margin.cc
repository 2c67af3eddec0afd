#include "graph/shared_margin.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "primitives/cubic_resample.h"
#include "primitives/rotation_math.h"
#include "primitives/time_warp.h"
#include "primitives/whitening.h"

namespace morphograph {
namespace {

constexpr int kTimes = 7;           // at which the motion is taken
constexpr double kReach = 0.8;      // of the margin, in steps of mean duration: shorter steps have shorter margins
constexpr double kStep = 0.25;      // of the central differences, in standard deviations

double UsualDuration(const MotionPrimitive& primitive) {
  return std::exp(primitive.reduction.mean[primitive.reduction.mean.size() - kTimingValues]);
}

class MarginReader {
 public:
  MarginReader(const PoseLayout& layout, const MeanRotations& means, const Eigen::VectorXd& weights, double reach_s)
      : layout_(layout), means_(means), weights_(weights), reach_s_(reach_s), spline_(kPhaseSamples) {
    const Eigen::Quaterniond& mean = means[static_cast<size_t>(layout.active_joints()[0])];
    upright_ = Yaw(-layout.HeadingOf(mean)) * mean;
  }

  // The values of SharedMargin about the last key frame of a step, or about its first one.
  Eigen::VectorXd Read(const StepShape& shape, bool at_end) const {
    const TimeWarp warp = TimeWarp::FromLogSlopes(shape.log_slopes);
    Eigen::VectorXd positions(kTimes);
    for (int i = 0; i < kTimes; ++i) {
      const double time_s = reach_s_ * (2.0 * i / (kTimes - 1) - 1);
      positions[i] = (warp.Inverse((at_end ? 1.0 : 0.0) + time_s / shape.duration_s) + kPhaseMargin) / kPhaseSpacing;
    }
    const Eigen::MatrixXd poses = spline_.Interpolate(shape.poses, positions);
    const Eigen::Index joints = poses.rows() - 6;
    Eigen::VectorXd values(kTimes * (joints + 4) + (kTimes - 1) * 3);
    Eigen::Index at = 0;
    double heading_before = 0;
    for (int i = 0; i < kTimes; ++i) {
      const auto pose = poses.col(i);
      const Eigen::Quaterniond rotation =
          layout_.RotationOf(0, means_[static_cast<size_t>(layout_.active_joints()[0])], pose.segment<3>(3));
      const double heading = layout_.HeadingOf(rotation);
      values[at++] = weights_[1] * pose[1];
      values.segment<3>(at) = weights_.segment<3>(3).cwiseProduct(LogMapAbout(upright_, Yaw(-heading) * rotation));
      values.segment(at + 3, joints) = weights_.tail(joints).cwiseProduct(pose.tail(joints));
      at += 3 + joints;
      if (i > 0) {
        const Eigen::Vector3d moved = Yaw(-heading_before) * Eigen::Vector3d(pose[0] - poses(0, i - 1), 0, pose[2] - poses(2, i - 1));
        values[at++] = weights_[0] * moved.x();
        values[at++] = weights_[2] * moved.z();
        values[at++] = weights_[4] * std::remainder(heading - heading_before, 2 * M_PI);
      }
      heading_before = heading;
    }
    return values;
  }

  // By the whitened latents of a component, at its mean.
  Eigen::MatrixXd Jacobian(const MotionPrimitive& primitive, const MixtureComponent& component, bool at_end) const {
    const auto read = [&](const Eigen::VectorXd& whitened) { return Read(primitive.Shape(Colour(component, whitened)), at_end); };
    const Eigen::Index size = component.mean.size();
    Eigen::MatrixXd jacobian;
    for (Eigen::Index d = 0; d < size; ++d) {
      const Eigen::VectorXd ahead = kStep * Eigen::VectorXd::Unit(size, d);
      const Eigen::VectorXd change = (read(ahead) - read(-ahead)) / (2 * kStep);
      if (d == 0) jacobian.resize(change.size(), size);
      jacobian.col(d) = change;
    }
    return jacobian;
  }

 private:
  const PoseLayout& layout_;
  const MeanRotations& means_;
  const Eigen::VectorXd& weights_;
  double reach_s_;
  UniformCubicSpline spline_;
  Eigen::Quaterniond upright_;  // the root's mean without its heading
};

}  // namespace

SharedMargin FindSharedMargin(const MotionPrimitive& from, const MotionPrimitive& to, const PoseLayout& layout, const MeanRotations& means,
                              const Eigen::VectorXd& channel_weights) {
  const double reach_s = kReach * kPhaseMargin * std::min(UsualDuration(from), UsualDuration(to));
  const MarginReader reader(layout, means, channel_weights, reach_s);
  SharedMargin margin;
  for (const MixtureComponent& component : from.mixture.components()) margin.end.push_back(reader.Jacobian(from, component, true));
  for (const MixtureComponent& component : to.mixture.components()) margin.start.push_back(reader.Jacobian(to, component, false));
  return margin;
}

SharedMarginMap::SharedMarginMap(const Eigen::MatrixXd& end, const Eigen::MatrixXd& start)
    : information_(start.transpose() * start), shared_(start.transpose() * end) {}

Eigen::MatrixXd SharedMarginMap::WithNoise(double noise_variance) const {
  Eigen::MatrixXd information = information_;
  information.diagonal().array() += noise_variance;
  return information.llt().solve(shared_);
}

}  // namespace morphograph
