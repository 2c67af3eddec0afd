#include "datasets/retarget.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "datasets/foot_retarget.h"
#include "datasets/forward_kinematics.h"
#include "datasets/turn_between.h"

namespace morphograph {
namespace {

constexpr double kSameDirectionCosine = 0.94;  // 20 degrees: how far people of one data set differ
constexpr double kShortBone_m = 0.03;           // has no direction to speak of
constexpr JointRole kTrunk[] = {JointRole::kHips, JointRole::kSpine, JointRole::kChest, JointRole::kNeck,
                                JointRole::kHead};

Eigen::Matrix3Xd RestPositions(const Skeleton& skeleton) {
  const std::vector<Eigen::Quaterniond> identity(skeleton.joint_count(), Eigen::Quaterniond::Identity());
  WorldPose pose;
  ForwardKinematics(skeleton, identity.data(), Eigen::Vector3d::Zero(), &pose);
  return pose.positions;
}

// Yaw of the rest pose: where (left hip - right hip) x up points.
double CheckedRestYaw(const Skeleton& skeleton, const Eigen::Matrix3Xd& rest, const char* which) {
  const RoleMap& roles = skeleton.roles();
  if (const std::vector<std::string> missing = roles.Missing(LocomotionRoles()); !missing.empty()) {
    throw std::invalid_argument(std::string("Retarget: the ") + which + " has no joint for role '" + missing[0] + "'");
  }
  const auto at = [&](JointRole role) -> Eigen::Vector3d { return rest.col(roles[role]); };
  for (const auto& [hip, ankle] : {std::pair{JointRole::kLeftHip, JointRole::kLeftAnkle},
                                   std::pair{JointRole::kRightHip, JointRole::kRightAnkle}}) {
    const Eigen::Vector3d leg = (at(ankle) - at(hip)).normalized();
    if (!(leg.y() < -0.8)) {
      throw std::invalid_argument(std::string("Retarget: the rest pose of the ") + which + " does not stand upright");
    }
  }
  const Eigen::Vector3d forward = (at(JointRole::kLeftHip) - at(JointRole::kRightHip)).cross(Eigen::Vector3d::UnitY());
  if (!(forward.norm() > 1e-6)) {
    throw std::invalid_argument(std::string("Retarget: both hip joints of the ") + which + " lie at one place");
  }
  return std::atan2(forward.x(), forward.z());
}

// The joint whose direction a role's bone takes, in the rest pose.
JointRole BoneEnd(JointRole role) {
  switch (role) {
    case JointRole::kSpine: return JointRole::kChest;
    case JointRole::kChest: return JointRole::kNeck;
    case JointRole::kNeck: return JointRole::kHead;
    case JointRole::kLeftHip: return JointRole::kLeftKnee;
    case JointRole::kLeftKnee: return JointRole::kLeftAnkle;
    case JointRole::kRightHip: return JointRole::kRightKnee;
    case JointRole::kRightKnee: return JointRole::kRightAnkle;
    case JointRole::kLeftShoulder: return JointRole::kLeftElbow;
    case JointRole::kLeftElbow: return JointRole::kLeftWrist;
    case JointRole::kRightShoulder: return JointRole::kRightElbow;
    case JointRole::kRightElbow: return JointRole::kRightWrist;
    default: return role;  // pelvis, head, feet, toes, hands: as they turn away from rest
  }
}

// How a target joint takes its world rotation.
struct JointLink {
  int source = -1;                                                 // source joint, -1: see below
  Eigen::Quaterniond source_from_target = Eigen::Quaterniond::Identity();  // rest directions of the two
  int local_source = -1;  // joint of the same name whose local rotation is copied (fingers), when nothing else applies
  int above = -1, below = -1;  // linked joints of the trunk between which it is spread; -1: it follows its parent
  double part = 0;             // of the way from `above` to `below`
};

class Linker {
 public:
  Linker(const Skeleton& source, const Skeleton& target)
      : source_(source), target_(target), source_rest_(RestPositions(source)), target_rest_(RestPositions(target)) {
    const double yaw = CheckedRestYaw(source, source_rest_, "source") - CheckedRestYaw(target, target_rest_, "target");
    facing_ = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()));
  }

  std::vector<JointLink> Link() {
    links_.resize(static_cast<size_t>(target_.joint_count()));
    for (int i = 0; i < kJointRoleCount; ++i) LinkRole(static_cast<JointRole>(i));
    // A hand goes on from its forearm, whatever the arms do at rest.
    LinkHand(JointRole::kLeftElbow, JointRole::kLeftWrist);
    LinkHand(JointRole::kRightElbow, JointRole::kRightWrist);
    LinkClavicle(JointRole::kLeftShoulder);
    LinkClavicle(JointRole::kRightShoulder);
    SpreadTrunk();
    LinkNames();
    return links_;
  }

 private:
  bool Shared(JointRole role) const { return source_.roles().Has(role) && target_.roles().Has(role); }

  void LinkRole(JointRole role) {
    if (!Shared(role)) return;
    JointLink& link = links_[target_.roles()[role]];
    link.source = source_.roles()[role];
    link.source_from_target = facing_;
    const JointRole end = BoneEnd(role);
    if (end == role || !Shared(end)) return;
    const Eigen::Vector3d source_bone = source_rest_.col(source_.roles()[end]) - source_rest_.col(link.source);
    const Eigen::Vector3d target_bone =
        facing_ * (target_rest_.col(target_.roles()[end]) - target_rest_.col(target_.roles()[role]));
    if (source_bone.norm() < kShortBone_m || target_bone.norm() < kShortBone_m) return;
    link.source_from_target = TurnBetween(target_bone, source_bone) * facing_;
  }

  void LinkHand(JointRole elbow, JointRole wrist) {
    if (!Shared(elbow) || !Shared(wrist)) return;
    links_[target_.roles()[wrist]].source_from_target = links_[target_.roles()[elbow]].source_from_target;
  }

  // Clavicles have no role; they are the joints between the trunk and the upper arms.
  void LinkClavicle(JointRole shoulder) {
    if (!Shared(shoulder)) return;
    const int source = source_.parent(source_.roles()[shoulder]);
    const int target = target_.parent(target_.roles()[shoulder]);
    if (source < 0 || target < 0 || source_.roles().RoleOf(source) || target_.roles().RoleOf(target)) return;
    links_[target].source = source;
    links_[target].source_from_target = facing_;
  }

  void LinkNames() {
    for (int j = 1; j < target_.joint_count(); ++j) {
      const int source = source_.Find(target_.joint(j).name);
      if (source <= 0) continue;
      if (source_.joint(source_.parent(source)).name == target_.joint(target_.parent(j)).name) {
        links_[j].local_source = source;
      }
    }
  }

  void SpreadTrunk() {
    int below = -1;
    for (const JointRole top : {JointRole::kHead, JointRole::kNeck, JointRole::kChest, JointRole::kSpine}) {
      if (below < 0 && Shared(top)) below = target_.roles()[top];
    }
    while (below >= 0) {
      std::vector<int> between;
      int above = target_.parent(below);
      for (; above >= 0 && !IsTrunk(above); above = target_.parent(above)) between.push_back(above);
      if (above < 0) return;
      for (size_t i = 0; i < between.size(); ++i) {
        JointLink& link = links_[between[i]];
        link.above = above;
        link.below = below;
        link.part = static_cast<double>(between.size() - i) / static_cast<double>(between.size() + 1);
      }
      below = above == target_.moving_root() ? -1 : above;
    }
  }

  bool IsTrunk(int joint) const {
    return std::any_of(std::begin(kTrunk), std::end(kTrunk),
                       [&](JointRole role) { return Shared(role) && target_.roles()[role] == joint; });
  }

  const Skeleton& source_;
  const Skeleton& target_;
  const Eigen::Matrix3Xd source_rest_, target_rest_;
  Eigen::Quaterniond facing_;  // source rest from target rest
  std::vector<JointLink> links_;
};

// World rotations of the target; linked joints first, since spread ones look at a linked joint below them.
void TargetWorld(const Skeleton& target, const std::vector<JointLink>& links, const Eigen::Quaterniond* source_local,
                 const std::vector<Eigen::Quaterniond>& source_world, std::vector<Eigen::Quaterniond>* world) {
  world->resize(links.size());
  for (size_t j = 0; j < links.size(); ++j) {
    if (links[j].source >= 0) (*world)[j] = source_world[links[j].source] * links[j].source_from_target;
  }
  for (int j = 0; j < target.joint_count(); ++j) {
    const JointLink& link = links[j];
    if (link.source >= 0) continue;
    if (link.above >= 0) {
      (*world)[j] = (*world)[link.above].slerp(link.part, (*world)[link.below]);
    } else {
      (*world)[j] = target.parent(j) >= 0 ? (*world)[target.parent(j)] : Eigen::Quaterniond::Identity();
      if (link.local_source >= 0) (*world)[j] = (*world)[j] * source_local[link.local_source];
    }
    if (!target.IsBody(j)) (*world)[j].setIdentity();
  }
}

}  // namespace

bool SameRestPose(const Skeleton& a, const Skeleton& b) {
  if (a.joint_count() != b.joint_count() || a.moving_root() != b.moving_root()) return false;
  for (int j = 0; j < a.joint_count(); ++j) {
    if (a.joint(j).name != b.joint(j).name || a.parent(j) != b.parent(j)) return false;
    const Eigen::Vector3d &one = a.joint(j).offset_m, &other = b.joint(j).offset_m;
    if (std::min(one.norm(), other.norm()) < kShortBone_m) continue;
    // Places of the hip sockets and clavicles differ from person to person without turning any bone.
    const bool socket = a.roles().RoleOf(j) == JointRole::kLeftHip || a.roles().RoleOf(j) == JointRole::kRightHip ||
                        a.roles().RoleOf(j) == JointRole::kLeftShoulder || a.roles().RoleOf(j) == JointRole::kRightShoulder;
    if (!socket && one.normalized().dot(other.normalized()) < kSameDirectionCosine) return false;
  }
  return true;
}

bool SameBones(const Skeleton& a, const Skeleton& b) {
  if (!SameRestPose(a, b)) return false;
  for (int j = 0; j < a.joint_count(); ++j) {
    if (j != a.moving_root() && a.joint(j).offset_m != b.joint(j).offset_m) return false;
  }
  return true;
}

MotionClip Retarget(const MotionClip& clip, const std::shared_ptr<const Skeleton>& target) {
  if (!target) throw std::invalid_argument("Retarget: no target skeleton");
  const Skeleton& source = clip.skeleton();
  const bool same = SameRestPose(source, *target);
  MotionClip moved(target, clip.frame_rate_hz(), clip.frame_count());
  moved.name = clip.name;
  moved.style = clip.style;
  const double source_leg = source.leg_length_m(), target_leg = target->leg_length_m();
  const double scale = source_leg > 0 && target_leg > 0 ? target_leg / source_leg : 1;
  moved.root_positions() = scale * clip.root_positions();

  std::vector<JointLink> links;
  if (!same) links = Linker(source, *target).Link();
  WorldPose pose;
  std::vector<Eigen::Quaterniond> world;
  for (int f = 0; f < clip.frame_count(); ++f) {
    if (same) {
      for (int j = 0; j < clip.joint_count(); ++j) moved.rotation(f, j) = clip.rotation(f, j);
      continue;
    }
    ForwardKinematics(source, clip.rotations(f), clip.root_positions().col(f), &pose);
    TargetWorld(*target, links, clip.rotations(f), pose.rotations, &world);
    for (int j = 0; j < target->joint_count(); ++j) {
      const int parent = target->parent(j);
      Eigen::Quaterniond& rotation = moved.rotation(f, j);
      rotation = world[j];
      if (j != target->moving_root() && parent >= 0) rotation = world[parent].conjugate() * world[j];
      rotation.normalize();
      if (f > 0 && rotation.dot(moved.rotation(f - 1, j)) < 0) rotation.coeffs() *= -1;
    }
  }
  if (!SameBones(source, *target)) PlaceFeetAsIn(clip, scale, &moved);
  return moved;
}

}  // namespace morphograph
