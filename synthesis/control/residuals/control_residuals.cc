#include "synthesis/control/residuals/control_residuals.h"

#include <cmath>

#include "primitives/rotation_math.h"
#include "synthesis/control/floor_area.h"

namespace morphograph {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A step's end is its successor's beginning to within this: far below what is asked of clips, far above rounding.
const Eigen::Vector4d kJoinDeviation(1e-3, 1e-3, 2e-3, 1e-3);

Eigen::VectorXd Vector(const double* values, int size) { return Eigen::Map<const Eigen::VectorXd>(values, size); }

void Write(const Eigen::MatrixXd& jacobian, double* out) {
  if (out) Eigen::Map<RowMajor>(out, jacobian.rows(), jacobian.cols()) = jacobian;
}

// A joint's frame turned by d about the world's axes turns a vector v fixed in it by d x v.
Eigen::MatrixXd TurnedBy(const Eigen::MatrixXd& turns, const Eigen::Vector3d& v) {
  Eigen::MatrixXd moved(3, turns.cols());
  for (Eigen::Index c = 0; c < turns.cols(); ++c) moved.col(c) = Eigen::Vector3d(turns.col(c)).cross(v);
  return moved;
}

}  // namespace

InnovationResidual::InnovationResidual(StepInnovation innovation, Eigen::VectorXd drawn) : innovation_(std::move(innovation)), drawn_(std::move(drawn)) {
  set_num_residuals(innovation_.dimension());
  *mutable_parameter_block_sizes() = {innovation_.previous_dimension(), innovation_.dimension()};
}

bool InnovationResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::VectorXd previous = Vector(parameters[0], parameter_block_sizes()[0]);
  const Eigen::VectorXd next = Vector(parameters[1], parameter_block_sizes()[1]);
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = innovation_.Value(previous, next) - drawn_;
  if (!jacobians) return true;
  if (jacobians[0]) Write(innovation_.ByPrevious(previous), jacobians[0]);
  Write(innovation_.ByNext(), jacobians[1]);
  return true;
}

FirstStepResidual::FirstStepResidual(Eigen::VectorXd drawn, Eigen::VectorXd scale) : drawn_(std::move(drawn)), scale_(std::move(scale)) {
  set_num_residuals(static_cast<int>(drawn_.size()));
  mutable_parameter_block_sizes()->push_back(num_residuals());
}

bool FirstStepResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::VectorXd w = Vector(parameters[0], num_residuals());
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = (w - drawn_).cwiseQuotient(scale_);
  if (jacobians) Write(Eigen::MatrixXd(scale_.cwiseInverse().asDiagonal()), jacobians[0]);
  return true;
}

RadiusResidual::RadiusResidual(int dimension, double radius, double deviation) : radius_(radius), deviation_(deviation) {
  set_num_residuals(1);
  mutable_parameter_block_sizes()->push_back(dimension);
}

bool RadiusResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::VectorXd w = Vector(parameters[0], parameter_block_sizes()[0]);
  const double norm = w.norm();
  const bool outside = norm > radius_ && norm > 0;
  residuals[0] = outside ? (norm - radius_) / deviation_ : 0;
  if (jacobians) Write(outside ? Eigen::MatrixXd(w.transpose() / (norm * deviation_)) : Eigen::MatrixXd::Zero(1, w.size()), jacobians[0]);
  return true;
}

NextPlaceResidual::NextPlaceResidual(std::shared_ptr<const StepKinematics> step, const Eigen::Vector3d* offset, double looseness)
    : step_(std::move(step)), offset_(offset), looseness_(looseness) {
  set_num_residuals(4);
  *mutable_parameter_block_sizes() = {step_->dimension(), 4, 4};
}

bool NextPlaceResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const KeyframePlace place(parameters[1]), next(parameters[2]);
  PlaceState state = step_->Next(Vector(parameters[0], step_->dimension()), place);
  const double c = std::cos(place[kPlaceHeading]), s = std::sin(place[kPlaceHeading]);
  const Eigen::Vector2d moved(c * (*offset_)[0] + s * (*offset_)[1], -s * (*offset_)[0] + c * (*offset_)[1]);
  state.value.head<2>() += moved;
  state.value[kPlaceHeading] += (*offset_)[2];
  state.by_place(kPlaceX, kPlaceHeading) += moved.y();
  state.by_place(kPlaceZ, kPlaceHeading) -= moved.x();
  const Eigen::Vector4d weights = (looseness_ * kJoinDeviation).cwiseInverse();
  Eigen::Map<Eigen::Vector4d>(residuals).array() = (next - state.value).array() * weights.array();
  if (!jacobians) return true;
  Write(-(weights.asDiagonal() * state.by_latent), jacobians[0]);
  Write(-(weights.asDiagonal() * state.by_place), jacobians[1]);
  Write(Eigen::MatrixXd(weights.asDiagonal()), jacobians[2]);
  return true;
}

StartResidual::StartResidual(const KeyframePlace& place, const Eigen::Vector4d& deviation) : place_(place), deviation_(deviation) {
  set_num_residuals(4);
  mutable_parameter_block_sizes()->push_back(4);
}

bool StartResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  Eigen::Map<Eigen::Vector4d>(residuals).array() = (Eigen::Map<const Eigen::Vector4d>(parameters[0]) - place_).array() / deviation_.array();
  if (jacobians) Write(Eigen::MatrixXd(deviation_.cwiseInverse().asDiagonal()), jacobians[0]);
  return true;
}

ArrivalResidual::ArrivalResidual(double time_s, double deviation_s) : time_s_(time_s), deviation_s_(deviation_s) {
  set_num_residuals(1);
  mutable_parameter_block_sizes()->push_back(4);
}

bool ArrivalResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  residuals[0] = (parameters[0][kPlaceTime] - time_s_) / deviation_s_;
  if (jacobians) Write(Eigen::RowVector4d(0, 0, 0, 1 / deviation_s_), jacobians[0]);
  return true;
}

StepResidual::StepResidual(std::shared_ptr<const StepKinematics> step, int residuals) : step_(std::move(step)) {
  set_num_residuals(residuals);
  *mutable_parameter_block_sizes() = {step_->dimension(), 4};
}

const StepResidual::Linear& StepResidual::At(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  if (latest_w_.size() == 0 || w != latest_w_ || place != latest_place_) {
    latest_ = Linearise(w, place);
    latest_w_ = w;
    latest_place_ = place;
  }
  return latest_;
}

bool StepResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Linear& linear = At(Vector(parameters[0], step_->dimension()), KeyframePlace(parameters[1]));
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = linear.value;
  if (!jacobians) return true;
  Write(linear.by_latent, jacobians[0]);
  Write(linear.by_place, jacobians[1]);
  return true;
}

PathResidual::PathResidual(std::shared_ptr<const StepKinematics> step, const StepMoment& moment, const FloorPath& path, double from_m, double to_m,
                           double deviation_m)
    : StepResidual(std::move(step), 1), moment_(moment), path_(path), from_m_(from_m), to_m_(to_m), deviation_m_(deviation_m) {}

StepResidual::Linear PathResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const FloorState root = step().Root(moment_, w, place);
  const Eigen::Vector2d point = root.value.head<2>();
  const FloorPath::Nearest nearest = path_.NearestTo(point, from_m_, to_m_);
  const Eigen::Vector2d direction = path_.Direction(nearest.along_m);
  const Eigen::Vector2d left(direction.y(), -direction.x());
  const Eigen::Vector2d off = point - nearest.point_m;
  // At a corner the distance is the one from that point; beyond the part of the path that counts, the one from its line.
  const bool inside = nearest.along_m > std::max(0.0, from_m_) && nearest.along_m < std::min(path_.length_m(), to_m_);
  Eigen::RowVector2d gradient = left.transpose();
  if (inside && nearest.distance_m > 1e-9) gradient = std::copysign(1 / nearest.distance_m, left.dot(off)) * off.transpose();
  gradient /= deviation_m_;
  return {Eigen::VectorXd::Constant(1, gradient.dot(off)), gradient * root.by_latent.topRows<2>(), gradient * root.by_place.topRows<2>()};
}

RootResidual::RootResidual(std::shared_ptr<const StepKinematics> step, const StepMoment& moment, const Eigen::Vector3d& target,
                           const Eigen::Vector3d& deviation, const Eigen::Vector3d* offset)
    : StepResidual(std::move(step), 3), moment_(moment), target_(target), deviation_(deviation), offset_(offset) {}

StepResidual::Linear RootResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const FloorState root = step().Root(moment_, w, place);
  const Eigen::Vector3d weights = deviation_.cwiseInverse();
  Eigen::Vector3d miss = root.value + *offset_ - target_;
  miss[2] = std::remainder(miss[2], 2 * M_PI);
  return {weights.cwiseProduct(miss), weights.asDiagonal() * root.by_latent, weights.asDiagonal() * root.by_place};
}

JointPositionResidual::JointPositionResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment,
                                             const Eigen::Vector3d& target_m, const Eigen::Vector3d& deviation_m, const Eigen::Vector3d* offset)
    : StepResidual(std::move(step), 3), chain_(std::move(chain)), moment_(moment), target_m_(target_m), deviation_m_(deviation_m), offset_(offset) {}

StepResidual::Linear JointPositionResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const PointState joint = step().Joint(*chain_, moment_, w, place);
  const Eigen::Vector3d weights = deviation_m_.cwiseInverse();
  return {weights.cwiseProduct(joint.position_m + *offset_ - target_m_), weights.asDiagonal() * joint.position_by_latent,
          weights.asDiagonal() * joint.position_by_place};
}

JointOrientationResidual::JointOrientationResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain,
                                                   const StepMoment& moment, const Eigen::Quaterniond& target, double deviation_rad)
    : StepResidual(std::move(step), 3), chain_(std::move(chain)), moment_(moment), target_(target), deviation_rad_(deviation_rad) {}

StepResidual::Linear JointOrientationResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const PointState joint = step().Joint(*chain_, moment_, w, place);
  const Eigen::Vector3d turn = LogMap(target_.conjugate() * Eigen::Quaterniond(joint.rotation));
  // exp(turn) = target^-1 R; R turned by d about the world's axes is exp(turn) exp(R^-1 d).
  const Eigen::Matrix3d by_turn = RightJacobian(turn).inverse() * joint.rotation.transpose() / deviation_rad_;
  return {turn / deviation_rad_, by_turn * joint.turn_by_latent, by_turn * joint.turn_by_place};
}

LookAtResidual::LookAtResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment,
                               const Eigen::Vector3d& forward, const Eigen::Vector3d& point_m, double deviation_rad)
    : StepResidual(std::move(step), 3), chain_(std::move(chain)), moment_(moment), forward_(forward), point_m_(point_m), deviation_rad_(deviation_rad) {}

StepResidual::Linear LookAtResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const PointState joint = step().Joint(*chain_, moment_, w, place);
  const Eigen::Vector3d facing = joint.rotation * forward_;
  const Eigen::Vector3d to_point = point_m_ - joint.position_m;
  const double distance = std::max(to_point.norm(), 1e-6);
  const Eigen::Vector3d wanted = to_point / distance;
  const Eigen::Matrix3d by_position = -(Eigen::Matrix3d::Identity() - wanted * wanted.transpose()) / distance;
  return {(facing - wanted) / deviation_rad_,
          (TurnedBy(joint.turn_by_latent, facing) - by_position * joint.position_by_latent) / deviation_rad_,
          (TurnedBy(joint.turn_by_place, facing) - by_position * joint.position_by_place) / deviation_rad_};
}

SpeedResidual::SpeedResidual(std::shared_ptr<const StepKinematics> step, double speed_m_s, double deviation_m_s)
    : StepResidual(std::move(step), 1), speed_m_s_(speed_m_s), deviation_m_s_(deviation_m_s) {}

StepResidual::Linear SpeedResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const PlaceState next = step().Next(w, place);
  const Eigen::Vector2d moved = next.value.head<2>() - place.head<2>();
  const double distance = std::max(moved.norm(), 1e-9), duration = next.value[kPlaceTime] - place[kPlaceTime];
  const double scale = 1 / (duration * deviation_m_s_);
  const Eigen::RowVector2d ahead = moved.transpose() / distance;
  // The place moves and turns both ends of the step alike.
  return {Eigen::VectorXd::Constant(1, (distance / duration - speed_m_s_) / deviation_m_s_),
          scale * (ahead * next.by_latent.topRows<2>() - distance / duration * next.by_latent.row(kPlaceTime)), Eigen::RowVector4d::Zero()};
}

KeepOutResidual::KeepOutResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment,
                                 const KeepOutTerm& area, double margin_m, double deviation_m)
    : StepResidual(std::move(step), 1), chain_(std::move(chain)), moment_(moment), area_(area), margin_m_(margin_m), deviation_m_(deviation_m) {}

StepResidual::Linear KeepOutResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  Eigen::Vector2d point;
  Eigen::MatrixXd by_latent;
  Eigen::Matrix<double, 2, 4> by_place;
  if (chain_) {
    const PointState joint = step().Joint(*chain_, moment_, w, place);
    point = {joint.position_m.x(), joint.position_m.z()};
    by_latent.resize(2, joint.position_by_latent.cols());
    by_latent << joint.position_by_latent.row(0), joint.position_by_latent.row(2);
    by_place << joint.position_by_place.row(0), joint.position_by_place.row(2);
  } else {
    const FloorState root = step().Root(moment_, w, place);
    point = root.value.head<2>();
    by_latent = root.by_latent.topRows<2>();
    by_place = root.by_place.topRows<2>();
  }
  Eigen::RowVector2d gradient;
  const double depth = area_.Depth(point, &gradient) + margin_m_;
  if (depth <= 0) return {Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(1, by_latent.cols()), Eigen::RowVector4d::Zero()};
  return {Eigen::VectorXd::Constant(1, depth / deviation_m_), gradient / deviation_m_ * by_latent, gradient / deviation_m_ * by_place};
}

}  // namespace morphograph
