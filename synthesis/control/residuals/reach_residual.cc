#include "synthesis/control/residuals/reach_residual.h"

#include <algorithm>
#include <limits>

#include "synthesis/foot_lock.h"

namespace morphograph {
namespace {

constexpr FootLockOptions kLock;  // the lock that a clip is finished by

}  // namespace

ReachResidual::ReachResidual(std::shared_ptr<const StepKinematics> step, std::vector<PlantedMoment> moments, double deviation_m)
    : StepResidual(std::move(step), static_cast<int>(moments.size())), moments_(std::move(moments)), deviation_m_(deviation_m) {}

// Lengths and heights are the same in the step's own frame as in the world. Derivatives are taken by the pose first, and only where there is something missing.
StepResidual::Linear ReachResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace&) const {
  const auto count = static_cast<Eigen::Index>(moments_.size());
  Linear linear{Eigen::VectorXd::Zero(count), Eigen::MatrixXd::Zero(count, w.size()), Eigen::MatrixXd::Zero(count, 4)};
  double phase = std::numeric_limits<double>::quiet_NaN();
  const StepModel::Map* map = nullptr;
  Eigen::VectorXd pose;
  for (Eigen::Index i = 0; i < count; ++i) {
    const PlantedMoment& moment = moments_[static_cast<size_t>(i)];
    if (moment.phase != phase) {
      phase = moment.phase;
      map = &step().model().KeptPose(phase);
      pose = map->offset + map->by_latent * w;
    }
    const JointState ankle = moment.ankle->At(pose), ball = moment.ball->At(pose);
    const Eigen::Vector3d heel = ankle.rotation * moment.heel_offset_m;
    const double weight = kLock.level / (1 + kLock.level * (moment.hold[0] + moment.hold[1]));
    const double drop = weight * (moment.hold[0] * (ankle.position_m.y() + heel.y() - moment.height_m[0]) + moment.hold[1] * (ball.position_m.y() - moment.height_m[1]));
    if (drop <= 0) continue;
    const JointState hip = moment.hip->At(pose);
    const Eigen::Vector3d leg = ankle.position_m - hip.position_m, wanted = leg - drop * Eigen::Vector3d::UnitY();
    const double length = leg.norm(), wanted_length = wanted.norm();
    const double missing = wanted_length - length - kLock.stretch * std::max(0.0, moment.leg_length_m - length);
    if (missing <= 0) continue;
    // A turn d of the foot moves its heel by d x heel: (d x heel)_y = d_z heel_x - d_x heel_z.
    const Eigen::RowVectorXd drop_by_pose =
        weight * (moment.hold[0] * (ankle.position_by_pose.row(1) + heel.x() * ankle.turn_by_pose.row(2) - heel.z() * ankle.turn_by_pose.row(0)) + moment.hold[1] * ball.position_by_pose.row(1));
    const double by_length = length < moment.leg_length_m ? 1 - kLock.stretch : 1;
    const Eigen::RowVector3d by_leg = wanted.transpose() / wanted_length - by_length / length * leg.transpose();
    const Eigen::RowVectorXd by_pose = by_leg * (ankle.position_by_pose - hip.position_by_pose) - wanted.y() / wanted_length * drop_by_pose;
    linear.value[i] = missing / deviation_m_;
    linear.by_latent.row(i) = by_pose * map->by_latent / deviation_m_;
  }
  return linear;
}

}  // namespace morphograph
