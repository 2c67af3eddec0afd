#include "synthesis/control/pose_layer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "primitives/rotation_math.h"
#include "synthesis/control/arm_range.h"

namespace morphograph {
namespace {

constexpr int kIterations = 20;
constexpr double kStuck = 0.999;  // part of a miss that an iteration leaves at most, or it is out of reach
constexpr double kLargestStep_rad = 0.25;  // of an iteration
constexpr double kLeanFor_m = 2e-3;  // the trunk helps where an arm alone misses its point by more
constexpr double kLean_rad = 0.26;   // of the trunk against the walk's, all its joints together
constexpr double kClose_m = 2e-4, kClose_rad = 1e-3;
constexpr double kEaseIn_s = 0.25, kEaseSpeed_rad_s = 2.5, kLongestEase_s = 0.9;
constexpr double kHeadTurn_rad = 1.2;  // of the head against the trunk, all joints of the neck together; for a look up to kOwnTurn times as much
constexpr double kOwnTurn = 1.3;  // of a link's limit: how far from its neutral rotation a walk itself may have it
constexpr double kStraightest_rad = 0.12, kMostBent_rad = 2.6;  // flexion of an elbow

bool IsAncestor(const Skeleton& skeleton, int ancestor, int joint) {
  for (int j = joint; j >= 0; j = skeleton.parent(j)) {
    if (j == ancestor) return true;
  }
  return false;
}

// Rises from 0 to 1, twice differentiable.
double SmoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (6 * t - 15) + 10);
}

// The range of the chain's upper arm, given the trunk of a pose; without an arm, nothing.
std::optional<ArmRange> RangeOf(const Skeleton& skeleton, const LimbChain& chain, const WorldPose& before) {
  for (const LimbChain::Link& link : chain.links()) {
    if (link.elbow >= 0) return ArmRange(skeleton, before, link.joint, link.elbow, link.wrist);
  }
  return std::nullopt;
}

// Turns an upper arm that is out of its range back into it. True where it did.
bool KeepInRange(const Skeleton& skeleton, const LimbChain& chain, const ArmRange& range, const WorldPose& pose, Eigen::Quaterniond* rotations) {
  const std::optional<Eigen::Quaterniond> back = range.Back(pose);
  if (!back) return false;
  for (const LimbChain::Link& link : chain.links()) {
    if (link.elbow < 0) continue;
    const Eigen::Quaterniond parent = pose.rotations[static_cast<size_t>(skeleton.parent(link.joint))];
    Eigen::Quaterniond& rotation = rotations[link.joint];
    rotation = (parent.conjugate() * *back * parent * rotation).normalized();
  }
  return true;
}

// A rotation brought back to within a link's limit, which opens up to where the clip itself has the joint as its part in the goal goes to 0.
Eigen::Quaterniond Limited(const Eigen::Quaterniond& rotation, const Eigen::Quaterniond& free, double part, const LimbChain::Link& link, const PoseGoal& goal) {
  const Eigen::Quaterniond from = goal.neutral.empty() ? free : goal.neutral.at(static_cast<size_t>(link.joint));
  const double own = from.angularDistance(free);
  const double limit = std::max(link.limit_rad, own + part * (std::min(kOwnTurn * link.limit_rad, own) - own));
  const Eigen::Vector3d all = LogMap(from.conjugate() * rotation);
  return all.norm() > limit ? from * ExpMap(all * (limit / all.norm())) : rotation;
}

using Turns = std::vector<Eigen::Vector3d>;  // of each link, in its joint's own frame

class FrameSolver {
 public:
  FrameSolver(const MotionClip& before, const MotionClip& clip, int frame, const PoseGoal& goal, const LimbChain& chain)
      : skeleton_(clip.skeleton()), root_(clip.root_positions().col(frame)), goal_(goal), chain_(chain), frame_(frame) {
    free_.assign(before.rotations(frame), before.rotations(frame) + before.joint_count());
    original_.assign(clip.rotations(frame), clip.rotations(frame) + clip.joint_count());
    rotations_ = original_;
    ForwardKinematics(skeleton_, free_.data(), root_, &pose_);
    range_ = RangeOf(skeleton_, chain, pose_);
    ForwardKinematics(skeleton_, rotations_.data(), root_, &pose_);
    if (goal_.position) target_ = goal_.position(frame_, pose_);
  }

  Turns Solve() {
    Iterate(chain_.limb_size());
    if (goal_.position && chain_.links().size() > chain_.limb_size() && Miss().norm() > kLeanFor_m) Iterate(chain_.links().size());
    Turns turns;
    for (const LimbChain::Link& link : chain_.links()) turns.push_back(TurnOf(link.joint));
    return turns;
  }

  int poses() const { return poses_; }

 private:
  Eigen::Vector3d Miss() const { return goal_.position ? Eigen::Vector3d(target_ - pose_.positions.col(goal_.joint)) : goal_.turn(frame_, pose_); }

  // With the first so many links of the chain.
  void Iterate(size_t links) {
    double before = 0;
    for (int i = 0; i < kIterations; ++i) {
      const Eigen::Vector3d miss = Miss();
      if (miss.norm() < (goal_.position ? kClose_m : kClose_rad) || (i > 2 && miss.norm() > kStuck * before)) break;
      before = miss.norm();
      Step(miss, links);
    }
  }

  Eigen::Vector3d TurnOf(int joint) const {
    const auto j = static_cast<size_t>(joint);
    return LogMap(original_[j].conjugate() * rotations_[j]);
  }

  // Bones on both sides of an elbow, in the world.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> Bones(int elbow) const {
    int below = goal_.joint;
    while (skeleton_.parent(below) != elbow) below = skeleton_.parent(below);
    const Eigen::Vector3d here = pose_.positions.col(elbow);
    return {here - pose_.positions.col(skeleton_.parent(elbow)), pose_.positions.col(below) - here};
  }

  void Step(const Eigen::Vector3d& miss, size_t links) {
    ++poses_;
    struct Axis {
      size_t link;
      Eigen::Vector3d world;
    };
    std::vector<Axis> axes;
    for (size_t k = 0; k < links; ++k) {
      const LimbChain::Link& link = chain_.links()[k];
      if (link.is_elbow) {
        const auto [upper, lower] = Bones(link.joint);
        const Eigen::Vector3d hinge = upper.cross(lower);
        if (hinge.norm() > 1e-6) axes.push_back({k, hinge.normalized()});
      } else {
        for (int axis = 0; axis < 3; ++axis) axes.push_back({k, Eigen::Vector3d::Unit(axis)});
      }
    }
    Eigen::MatrixXd jacobian(3, axes.size());
    Eigen::VectorXd ease(axes.size());
    for (size_t a = 0; a < axes.size(); ++a) {
      const LimbChain::Link& link = chain_.links()[axes[a].link];
      const Eigen::Vector3d arm = pose_.positions.col(goal_.joint) - pose_.positions.col(link.joint);
      jacobian.col(static_cast<Eigen::Index>(a)) = goal_.position ? axes[a].world.cross(arm) : axes[a].world;
      ease[static_cast<Eigen::Index>(a)] = link.ease;
    }
    const Eigen::MatrixXd eased = ease.asDiagonal() * jacobian.transpose();
    const double damping = 1e-3 * (jacobian * eased).trace() / 3;
    Eigen::VectorXd turn = eased * (jacobian * eased + damping * Eigen::Matrix3d::Identity()).ldlt().solve(miss);
    const double largest = turn.cwiseAbs().maxCoeff();
    if (largest > kLargestStep_rad) turn *= kLargestStep_rad / largest;

    std::vector<Eigen::Vector3d> of_link(links, Eigen::Vector3d::Zero());
    for (size_t a = 0; a < axes.size(); ++a) of_link[axes[a].link] += turn[static_cast<Eigen::Index>(a)] * axes[a].world;
    for (size_t k = 0; k < of_link.size(); ++k) Turn(chain_.links()[k], of_link[k]);
    ForwardKinematics(skeleton_, rotations_.data(), root_, &pose_);
    if (range_ && KeepInRange(skeleton_, chain_, *range_, pose_, rotations_.data())) ForwardKinematics(skeleton_, rotations_.data(), root_, &pose_);
  }

  // Turns a joint about the world's axes, within its limits.
  void Turn(const LimbChain::Link& link, Eigen::Vector3d world) {
    const auto j = static_cast<size_t>(link.joint);
    if (link.is_elbow) {
      const auto [upper, lower] = Bones(link.joint);
      const double flexion = std::atan2(upper.cross(lower).norm(), upper.dot(lower));
      const double wanted = world.norm() * (world.dot(upper.cross(lower)) < 0 ? -1 : 1);
      const double allowed = std::clamp(flexion + wanted, std::min(flexion, kStraightest_rad), std::max(flexion, kMostBent_rad)) - flexion;
      if (std::abs(wanted) > 1e-12) world *= allowed / wanted;
    }
    const Eigen::Quaterniond parent = pose_.rotations[static_cast<size_t>(skeleton_.parent(link.joint))];
    rotations_[j] = Limited((ExpMap(parent.conjugate() * world) * rotations_[j]).normalized(), free_[j], 1, link, goal_);
  }

  const Skeleton& skeleton_;
  Eigen::Vector3d root_;
  const PoseGoal& goal_;
  const LimbChain& chain_;
  int frame_;
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Quaterniond> free_, original_, rotations_;  // before any goal, before this one, now
  std::optional<ArmRange> range_;
  WorldPose pose_;
  int poses_ = 2;
};

}  // namespace

LimbChain::LimbChain(const Skeleton& skeleton, int joint) {
  const RoleMap& roles = skeleton.roles();
  const int shoulders[2] = {roles[JointRole::kLeftShoulder], roles[JointRole::kRightShoulder]};
  const int elbows[2] = {roles[JointRole::kLeftElbow], roles[JointRole::kRightElbow]};
  const int wrists[2] = {roles[JointRole::kLeftWrist], roles[JointRole::kRightWrist]};
  if (shoulders[0] < 0 || shoulders[1] < 0) return;
  const auto is_trunk = [&](int j) { return IsAncestor(skeleton, j, shoulders[0]) && IsAncestor(skeleton, j, shoulders[1]); };
  std::vector<Link> links;
  int j = joint;
  for (; j >= 0 && !is_trunk(j); j = skeleton.parent(j)) {
    if (roles.RoleOf(j) == JointRole::kLeftHip || roles.RoleOf(j) == JointRole::kRightHip) return;
    Link link{j, false, 1, 0.8};
    if (j == elbows[0] || j == elbows[1]) {
      link.is_elbow = j != joint;
      link.limit_rad = 2;
    } else if (j == shoulders[0] || j == shoulders[1]) {
      link.limit_rad = 1.6;
      const int side = j == shoulders[0] ? 0 : 1;
      if (elbows[side] >= 0 && wrists[side] >= 0) link.elbow = elbows[side], link.wrist = wrists[side];
    } else if (IsAncestor(skeleton, j, shoulders[0]) || IsAncestor(skeleton, j, shoulders[1])) {
      link = {j, false, 0.15, 0.35};  // collar bones follow, a little
    }
    links.push_back(link);
  }
  // Legs that do not pass a hip joint with a role, and everything else below the pelvis, are the walk's.
  if (j < 0 || j == skeleton.moving_root()) return;
  const bool is_head = std::none_of(links.begin(), links.end(), [&](const Link& link) { return IsAncestor(skeleton, shoulders[0], link.joint) || IsAncestor(skeleton, shoulders[1], link.joint); });
  if (is_head) {
    for (Link& link : links) link.limit_rad = kHeadTurn_rad / static_cast<double>(links.size());
  }
  limb_size_ = links.size();
  if (!is_head) {
    const size_t limb = links.size();
    for (; j >= 0 && j != skeleton.moving_root(); j = skeleton.parent(j)) links.push_back({j, false, 0.3, 0});
    for (size_t k = limb; k < links.size(); ++k) links[k].limit_rad = kLean_rad / static_cast<double>(links.size() - limb);
  }
  links_ = std::move(links);
}

int ApplyPoseGoal(const PoseGoal& goal, const MotionClip& before, MotionClip* clip) {
  const LimbChain chain(clip->skeleton(), goal.joint);
  if (chain.empty() || clip->frame_count() == 0) return 0;
  const int frames = clip->frame_count();
  const int first = std::clamp(goal.first_frame, 0, frames - 1), last = std::clamp(goal.last_frame, first, frames - 1);
  std::vector<Turns> turns;
  int poses = 0;
  for (int f = first; f <= last; ++f) {
    FrameSolver solver(before, *clip, f, goal, chain);
    turns.push_back(solver.Solve());
    poses += solver.poses();
  }
  const auto ease_frames = [&](const Turns& at) {
    double largest = 0;
    for (const Eigen::Vector3d& turn : at) largest = std::max(largest, turn.norm());
    return std::min(kLongestEase_s, kEaseIn_s + largest / kEaseSpeed_rad_s) * clip->frame_rate_hz();
  };
  const double ease_in = ease_frames(turns.front()), ease_out = ease_frames(turns.back());
  for (int f = 0; f < frames; ++f) {
    const double part = f < first ? SmoothStep(1 - (first - f) / ease_in) : f > last ? SmoothStep(1 - (f - last) / ease_out) : 1;
    if (part <= 0) continue;
    const Turns& at = turns[static_cast<size_t>(std::clamp(f, first, last) - first)];
    for (size_t k = 0; k < at.size(); ++k) {
      if (at[k].isZero(0)) continue;  // a trunk that need not lean stays as it is, to the last bit
      Eigen::Quaterniond& rotation = clip->rotation(f, chain.links()[k].joint);
      rotation = (rotation * ExpMap(part * at[k])).normalized();
      // Eased turns of several goals may add up.
      rotation = Limited(rotation, before.rotation(f, chain.links()[k].joint), part, chain.links()[k], goal);
    }
    if (const auto range = RangeOf(clip->skeleton(), chain, ForwardKinematics(before, f)))
      KeepInRange(clip->skeleton(), chain, *range, ForwardKinematics(*clip, f), &clip->rotation(f, 0));
  }
  return poses;
}

}  // namespace morphograph
