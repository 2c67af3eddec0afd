#include "synthesis/control/step_kinematics.h"

#include <Eigen/Geometry>
#include <cmath>

#include "primitives/rotation_math.h"
#include "primitives/time_warp.h"

namespace morphograph {
namespace {

Eigen::Matrix3d YawMatrix(double yaw) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  Eigen::Matrix3d matrix;
  matrix << c, 0, s, 0, 1, 0, -s, 0, c;
  return matrix;
}

// d (YawMatrix(yaw) v) / d yaw, where `turned` is YawMatrix(yaw) v.
Eigen::Vector3d ByYaw(const Eigen::Vector3d& turned) { return {turned.z(), 0, -turned.x()}; }

Eigen::VectorXd Evaluate(const StepModel::Map& map, const Eigen::VectorXd& w) { return map.offset + map.by_latent * w; }

}  // namespace

StepKinematics::StepKinematics(std::shared_ptr<const StepModel> model, const PoseLayout& layout, const Eigen::Quaterniond& mean_root)
    : model_(std::move(model)), mean_root_(mean_root), across_(layout.across_hips()), first_(model_->Root(0)), middle_(model_->Root(0.5)), second_(model_->Root(1)) {}

StepKinematics::Heading StepKinematics::HeadingOf(const Eigen::Vector3d& channels) const {
  const Eigen::Matrix3d rotation = ExpMapAbout(mean_root_, channels).toRotationMatrix();
  const Eigen::Vector3d across = rotation * across_;
  Heading heading;
  heading.value = std::atan2(-across.z(), across.x());
  // A turn d of the joint moves `across` by R (J d x across).
  Eigen::Matrix3d moved = RightJacobian(channels);
  for (int c = 0; c < 3; ++c) moved.col(c) = rotation * Eigen::Vector3d(moved.col(c)).cross(across_);
  const double norm2 = across.x() * across.x() + across.z() * across.z();
  heading.by_channels = (across.z() * moved.row(0) - across.x() * moved.row(2)) / norm2;
  return heading;
}

StepKinematics::Phase StepKinematics::PhaseAt(const StepMoment& moment, const Eigen::VectorXd& w, const KeyframePlace& place) const {
  Phase phase{moment.value, Eigen::RowVectorXd::Zero(dimension()), 0};
  if (!moment.is_time) return phase;
  const Eigen::VectorXd timing = Evaluate(model_->timing(), w);
  const double duration = std::exp(timing[0]);
  const TimeWarp warp = TimeWarp::FromLogSlopes(timing.tail(kWarpKnots));
  const double source = (moment.value - place[kPlaceTime]) / duration;
  phase.value = warp.Inverse(source);
  const double slope = warp.Slope(phase.value);
  phase.by_time = -1 / (duration * slope);
  phase.by_latent = (-source / slope) * model_->timing().by_latent.row(0) -
                    (warp.Gradient(phase.value).transpose() / slope) * model_->timing().by_latent.bottomRows(kWarpKnots);
  return phase;
}

StepKinematics::Frame StepKinematics::FrameOf(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const Eigen::VectorXd root = Evaluate(first_, w);
  const Heading heading = HeadingOf(root.tail<3>());
  Frame frame;
  frame.yaw = place[kPlaceHeading] - heading.value;
  frame.yaw_by_latent = -heading.by_channels * first_.by_latent.bottomRows<3>();
  frame.origin = {root[0], 0, root[2]};
  frame.origin_by_latent = first_.by_latent.topRows<3>();
  frame.origin_by_latent.row(1).setZero();
  return frame;
}

FloorState StepKinematics::Root(const StepMoment& moment, const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const Phase phase = PhaseAt(moment, w, place);
  const StepModel::Map map = model_->Root(phase.value);
  const Eigen::VectorXd root = Evaluate(map, w);
  Eigen::MatrixXd by_latent = map.by_latent;
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(6);
  if (moment.is_time) {
    rate = Evaluate(model_->RootRate(phase.value), w);
    by_latent += rate * phase.by_latent;
  }
  const Frame frame = FrameOf(w, place);
  const Heading heading = HeadingOf(root.tail<3>());
  const Eigen::Matrix3d yaw = YawMatrix(frame.yaw);
  const Eigen::Vector3d moved = yaw * (Eigen::Vector3d(root[0], 0, root[2]) - frame.origin);
  const Eigen::Vector3d by_yaw = ByYaw(moved);

  FloorState state;
  state.value = {place[kPlaceX] + moved.x(), place[kPlaceZ] + moved.z(), frame.yaw + heading.value};
  Eigen::MatrixXd local = by_latent.topRows<3>() - frame.origin_by_latent;
  local.row(1).setZero();
  const Eigen::MatrixXd world = yaw * local + by_yaw * frame.yaw_by_latent;
  state.by_latent.resize(3, dimension());
  state.by_latent.row(0) = world.row(0);
  state.by_latent.row(1) = world.row(2);
  state.by_latent.row(2) = frame.yaw_by_latent + heading.by_channels * by_latent.bottomRows<3>();
  state.by_place.setZero();
  state.by_place(0, kPlaceX) = state.by_place(1, kPlaceZ) = state.by_place(2, kPlaceHeading) = 1;
  state.by_place(0, kPlaceHeading) = by_yaw.x();
  state.by_place(1, kPlaceHeading) = by_yaw.z();
  if (moment.is_time) {
    const Eigen::Vector3d velocity = yaw * Eigen::Vector3d(rate[0], 0, rate[2]) * phase.by_time;
    state.by_place(0, kPlaceTime) = velocity.x();
    state.by_place(1, kPlaceTime) = velocity.z();
    state.by_place(2, kPlaceTime) = heading.by_channels.dot(rate.tail<3>()) * phase.by_time;
  }
  return state;
}

PointState StepKinematics::Joint(const JointChain& chain, const StepMoment& moment, const Eigen::VectorXd& w,
                                 const KeyframePlace& place) const {
  return Joints({&chain}, moment, w, place).front();
}

std::vector<PointState> StepKinematics::Joints(const std::vector<const JointChain*>& chains, const StepMoment& moment, const Eigen::VectorXd& w,
                                               const KeyframePlace& place) const {
  const Phase phase = PhaseAt(moment, w, place);
  const StepModel::Map map = model_->Pose(phase.value);
  const Eigen::VectorXd pose = Evaluate(map, w);
  Eigen::MatrixXd by_latent = map.by_latent;
  Eigen::VectorXd rate;
  if (moment.is_time) {
    rate = Evaluate(model_->PoseRate(phase.value), w);
    by_latent += rate * phase.by_latent;
  }
  const Frame frame = FrameOf(w, place);
  const Eigen::Matrix3d yaw = YawMatrix(frame.yaw);

  std::vector<PointState> states;
  for (const JointChain* chain : chains) {
    const JointState joint = chain->At(pose);
    const Eigen::Vector3d moved = yaw * (joint.position_m - frame.origin);
    const Eigen::Vector3d by_yaw = ByYaw(moved);
    PointState& state = states.emplace_back();
    state.position_m = moved + Eigen::Vector3d(place[kPlaceX], 0, place[kPlaceZ]);
    state.rotation = yaw * joint.rotation;
    state.position_by_latent = yaw * (joint.position_by_pose * by_latent - frame.origin_by_latent) + by_yaw * frame.yaw_by_latent;
    state.turn_by_latent = yaw * (joint.turn_by_pose * by_latent);
    state.turn_by_latent.row(1) += frame.yaw_by_latent;
    state.position_by_place.setZero();
    state.turn_by_place.setZero();
    state.position_by_place(0, kPlaceX) = state.position_by_place(2, kPlaceZ) = 1;
    state.position_by_place.col(kPlaceHeading) = by_yaw;
    state.turn_by_place(1, kPlaceHeading) = 1;
    if (moment.is_time) {
      state.position_by_place.col(kPlaceTime) = yaw * (joint.position_by_pose * rate) * phase.by_time;
      state.turn_by_place.col(kPlaceTime) = yaw * (joint.turn_by_pose * rate) * phase.by_time;
    }
  }
  return states;
}

StepKinematics::Way StepKinematics::WayOf(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const Eigen::VectorXd first = Evaluate(first_, w), middle = Evaluate(middle_, w), second = Evaluate(second_, w);
  const auto heading = [&](const Eigen::VectorXd& root) {
    const Eigen::Vector3d across = ExpMapAbout(mean_root_, root.tail<3>()) * across_;
    return std::atan2(-across.z(), across.x());
  };
  const double yaw = place[kPlaceHeading] - heading(first);
  const auto moved = [&](const Eigen::VectorXd& root) {
    const Eigen::Vector3d there = YawMatrix(yaw) * Eigen::Vector3d(root[0] - first[0], 0, root[2] - first[2]);
    return Eigen::Vector2d(place[kPlaceX] + there.x(), place[kPlaceZ] + there.z());
  };
  const Eigen::Vector2d end = moved(second);
  const double duration = std::exp(model_->timing().offset[0] + model_->timing().by_latent.row(0).dot(w));
  return {{end.x(), end.y(), yaw + heading(second), place[kPlaceTime] + duration}, moved(middle)};
}

PlaceState StepKinematics::Next(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const Eigen::VectorXd first = Evaluate(first_, w), second = Evaluate(second_, w);
  const Heading before = HeadingOf(first.tail<3>()), after = HeadingOf(second.tail<3>());
  const double yaw = place[kPlaceHeading] - before.value;
  const Eigen::RowVectorXd yaw_by_latent = -before.by_channels * first_.by_latent.bottomRows<3>();
  const Eigen::Matrix3d turn = YawMatrix(yaw);
  const Eigen::Vector3d moved = turn * Eigen::Vector3d(second[0] - first[0], 0, second[2] - first[2]);
  const Eigen::Vector3d by_yaw = ByYaw(moved);
  const double duration = std::exp(model_->timing().offset[0] + model_->timing().by_latent.row(0).dot(w));

  PlaceState next;
  next.value = {place[kPlaceX] + moved.x(), place[kPlaceZ] + moved.z(), yaw + after.value, place[kPlaceTime] + duration};
  Eigen::MatrixXd local = second_.by_latent.topRows<3>() - first_.by_latent.topRows<3>();
  local.row(1).setZero();
  const Eigen::MatrixXd world = turn * local + by_yaw * yaw_by_latent;
  next.by_latent.resize(4, dimension());
  next.by_latent.row(kPlaceX) = world.row(0);
  next.by_latent.row(kPlaceZ) = world.row(2);
  next.by_latent.row(kPlaceHeading) = yaw_by_latent + after.by_channels * second_.by_latent.bottomRows<3>();
  next.by_latent.row(kPlaceTime) = duration * model_->timing().by_latent.row(0);
  next.by_place.setIdentity();
  next.by_place(kPlaceX, kPlaceHeading) = by_yaw.x();
  next.by_place(kPlaceZ, kPlaceHeading) = by_yaw.z();
  return next;
}

KeyframePlace PlaceBefore(const StepKinematics& step, const Eigen::VectorXd& whitened, const KeyframePlace& root, double begins_s) {
  KeyframePlace place(0, 0, 0, begins_s);
  const Eigen::Vector3d there = step.Root({true, root[kPlaceTime]}, whitened, place).value;
  place[kPlaceHeading] = root[kPlaceHeading] - there[2];
  const double c = std::cos(place[kPlaceHeading]), s = std::sin(place[kPlaceHeading]);
  place[kPlaceX] = root[kPlaceX] - (c * there[0] + s * there[1]);
  place[kPlaceZ] = root[kPlaceZ] - (-s * there[0] + c * there[1]);
  return place;
}

}  // namespace morphograph
