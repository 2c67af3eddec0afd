#include "datasets/leg_ik.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/turn_between.h"

namespace morphograph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// A hinge axis shown by a bend of less than this (sine of 10 degrees) is completed by the foot's direction.
constexpr double kClearBendSine = 0.17;
// Weight of the pelvis beside the foot when the hinge axis is guessed; decides only where foot and shin are in line.
constexpr double kPelvisWeight = 0.3;

Vector3d OffsetFrom(const Skeleton& skeleton, int ancestor, int joint) {
  Vector3d offset = Vector3d::Zero();
  for (int j = joint; j != ancestor && j >= 0; j = skeleton.parent(j)) offset += skeleton.joint(j).offset_m;
  return offset;
}

// The turn of the shin that straightens a knee which is bent backwards; a bow to the side stays.
Quaterniond TakeOutBackwardBend(const Vector3d& thigh, const Vector3d& shin, const Vector3d& told) {
  const double bend = std::atan2(thigh.cross(shin).dot(told), thigh.dot(shin) - thigh.dot(told) * told.dot(shin));
  return Quaterniond(Eigen::AngleAxisd(std::max(0.0, -bend), told));
}

// The axis that the pose shows, pulled towards the one that foot and pelvis tell where the knee is nearly straight.
Vector3d Hinge(const Vector3d& thigh, const Vector3d& shin, const Vector3d& told) {
  const Vector3d shown = thigh.stableNormalized().cross(shin.stableNormalized());
  return (shown + std::max(0.0, kClearBendSine - shown.dot(told)) * told).stableNormalized();
}

}  // namespace

struct LegIk::Chain : LegPlace {
  Quaterniond world_from_root, world_from_hip_parent, world_from_hip, world_from_knee_parent, world_from_knee;
  Quaterniond world_from_ankle_parent;
};

LegIk::LegIk(const Skeleton& skeleton, Foot side, const LegIkOptions& options) : options_(options) {
  const RoleMap& roles = skeleton.roles();
  const std::vector<std::string> missing = roles.Missing(LocomotionRoles());
  if (!missing.empty()) throw std::invalid_argument("LegIk: no joint has the role " + missing.front());
  const bool left = side == Foot::kLeft;
  root_ = skeleton.moving_root();
  hip_ = roles[left ? JointRole::kLeftHip : JointRole::kRightHip];
  knee_ = roles[left ? JointRole::kLeftKnee : JointRole::kRightKnee];
  ankle_ = roles[left ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
  toe_ = roles[left ? JointRole::kLeftToe : JointRole::kRightToe];
  int found = 0;
  const int order[] = {toe_, ankle_, knee_, hip_, root_};
  for (int j = toe_; j >= 0 && found < 5; j = skeleton.parent(j)) {
    if (j == order[found]) ++found;
    if (j != root_) links_.push_back({j, skeleton.joint(j).offset_m});
  }
  if (found < 5) throw std::invalid_argument("LegIk: hips, hip, knee, ankle and toe do not follow each other");
  std::reverse(links_.begin(), links_.end());
  root_across_ = OffsetFrom(skeleton, root_, roles[JointRole::kLeftHip]) -
                 OffsetFrom(skeleton, root_, roles[JointRole::kRightHip]);

  for (int j = knee_; j != hip_; j = skeleton.parent(j)) thigh_m_ += skeleton.joint(j).offset_m.norm();
  for (int j = ankle_; j != knee_; j = skeleton.parent(j)) shin_m_ += skeleton.joint(j).offset_m.norm();
  if (!(thigh_m_ > 1e-6) || !(shin_m_ > 1e-6)) throw std::invalid_argument("LegIk: thigh or shin has no length");
}

LegIk::Chain LegIk::Follow(const Vector3d& root_m, const Quaterniond* rotations) const {
  Chain chain;
  chain.world_from_root = rotations[root_];
  Quaterniond world = rotations[root_];
  Vector3d position = root_m;
  for (const Link& link : links_) {
    position += world * link.offset_m;
    const Quaterniond world_from_parent = world;
    world = world * rotations[link.joint];
    if (link.joint == hip_) {
      chain.hip_m = position;
      chain.world_from_hip_parent = world_from_parent;
      chain.world_from_hip = world;
    } else if (link.joint == knee_) {
      chain.knee_m = position;
      chain.world_from_knee_parent = world_from_parent;
      chain.world_from_knee = world;
    } else if (link.joint == ankle_) {
      chain.ankle_m = position;
      chain.world_from_ankle_parent = world_from_parent;
      chain.world_from_foot = world;
    } else if (link.joint == toe_) {
      chain.toe_m = position;
    }
  }
  return chain;
}

// The hinge axis that foot and pelvis tell: unit; positive turns of the shin about it bend the knee.
Vector3d LegIk::ToldHinge(const Chain& chain) const {
  const Vector3d leg = (chain.ankle_m - chain.hip_m).stableNormalized();
  const Vector3d foot = (chain.toe_m - chain.ankle_m).stableNormalized();
  const Vector3d across = (chain.world_from_root * root_across_).stableNormalized();
  const Vector3d shin = (chain.ankle_m - chain.knee_m).stableNormalized();
  // Forwards x down points to the left of the body, as does across. The foot is held against the shin, which it leaves forwards
  // however far it is stretched; against the line from hip to ankle it would point backwards late in a high swing.
  const Vector3d told = (foot.cross(shin) + kPelvisWeight * (across - across.dot(leg) * leg)).stableNormalized();
  if (told.squaredNorm() < 0.5) return leg.unitOrthogonal();  // foot in line with the leg, pelvis edge-on
  return told;
}

LegPlace LegIk::Place(const Vector3d& root_m, const Quaterniond* rotations) const { return Follow(root_m, rotations); }

LegMeasure LegIk::Measure(const Vector3d& root_m, const Quaterniond* rotations) const {
  const Chain chain = Follow(root_m, rotations);
  const Vector3d thigh = (chain.knee_m - chain.hip_m).stableNormalized();
  const Vector3d shin = (chain.ankle_m - chain.knee_m).stableNormalized();
  const double bend = std::atan2(thigh.cross(shin).norm(), thigh.dot(shin));
  return {chain, std::copysign(bend, thigh.cross(shin).dot(ToldHinge(chain)))};
}

LegSolution LegIk::Solve(const Vector3d& ankle_m, const std::optional<Quaterniond>& world_from_foot,
                         const Vector3d& root_m, Quaterniond* rotations) const {
  const Chain chain = Follow(root_m, rotations);
  const Vector3d thigh = chain.knee_m - chain.hip_m;
  Vector3d shin = chain.ankle_m - chain.knee_m;
  const Vector3d told = ToldHinge(chain);
  const Quaterniond unbend = TakeOutBackwardBend(thigh, shin, told);
  shin = unbend * shin;
  const Vector3d hinge = Hinge(thigh, shin, told);

  // Turning the shin by `turn` about the hinge: thigh . shin' = along + cosine cos(turn) + sine sin(turn)
  //                                                           = along + reach cos(turn - straight).
  const double along = thigh.dot(hinge) * hinge.dot(shin);
  const double cosine = thigh.dot(shin) - along;
  const double sine = thigh.dot(hinge.cross(shin));
  const double reach = std::hypot(cosine, sine);
  const double straight = std::atan2(sine, cosine);
  const double squares = thigh.squaredNorm() + shin.squaredNorm();
  const double longest = std::sqrt(squares + 2 * (along + reach));

  const Vector3d to_target = ankle_m - chain.hip_m;
  double distance = to_target.norm();
  const double own = std::min((chain.ankle_m - chain.hip_m).norm(), longest);
  // A leg that the pose itself holds straighter than the soft zone may stay as it is.
  const double soft = std::max((1 - options_.soft_zone) * longest, own);
  if (distance > soft) {
    const double zone = longest - soft;
    distance = zone > 1e-12 ? longest - zone * std::exp(-(distance - soft) / zone) : longest;
  }
  const double bend_cosine = std::clamp(((distance * distance - squares) / 2 - along) / reach, -1.0, 1.0);
  double bend = std::min(std::acos(bend_cosine), options_.max_knee_bend_rad);
  // What a turn about the hinge leaves of a bow to the side may point backwards; bend at least as far as makes up for it.
  const Vector3d bow = thigh.cross(Eigen::AngleAxisd(straight, hinge) * shin);
  const double backwards = -bow.dot(told);
  const double forwards = reach * hinge.dot(told);
  if (backwards > 0) bend = std::max(bend, std::asin(std::min(1.0, backwards / forwards)));
  const Quaterniond knee_turn = Quaterniond(Eigen::AngleAxisd(straight + bend, hinge)) * unbend;

  const Vector3d hip_to_ankle = thigh + knee_turn * (chain.ankle_m - chain.knee_m);
  Quaterniond swing = Quaterniond::Identity();
  if (to_target.norm() > 1e-9) swing = TurnBetween(hip_to_ankle, to_target);

  rotations[hip_] = (chain.world_from_hip_parent.conjugate() * swing * chain.world_from_hip).normalized();
  rotations[knee_] = (chain.world_from_knee_parent.conjugate() * knee_turn * chain.world_from_knee).normalized();
  const Quaterniond world_from_ankle_parent = swing * knee_turn * chain.world_from_ankle_parent;
  rotations[ankle_] =
      (world_from_ankle_parent.conjugate() * world_from_foot.value_or(chain.world_from_foot)).normalized();
  return {(chain.hip_m + swing * hip_to_ankle - ankle_m).norm(), bend};
}

}  // namespace morphograph
