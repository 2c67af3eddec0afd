#include "datasets/marker_set.h"

#include <optional>
#include <stdexcept>

#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

// Lengths below are of a body with legs this long.
constexpr double kLegLength_m = 0.85;
constexpr int kFramesOfMean = 2000;  // plenty for a mean

struct MarkerPlace {
  const char* name;      // of the left one where there are two: "left_" is put before it
  JointRole joint;       // of the left side
  std::optional<JointRole> towards;  // the next joint along the bone
  double part;           // of the way there
  double left_m, up_m, forwards_m;   // from that point, in the body's directions
};

using enum JointRole;

const MarkerPlace kMiddle[] = {
    {"c7", kNeck, {}, 0, 0, 0.02, -0.06},
    {"t10", kSpine, kChest, 0.5, 0, 0, -0.12},
    {"clavicle", kChest, kNeck, 0.9, 0, 0, 0.06},
    {"sternum", kChest, kNeck, 0.2, 0, 0, 0.11},
    {"right_back", kChest, kNeck, 0.4, -0.08, 0, -0.11},
};

const MarkerPlace kSides[] = {
    {"front_head", kHead, {}, 0, 0.06, 0.10, 0.10},
    {"back_head", kHead, {}, 0, 0.06, 0.10, -0.09},
    {"asis", kHips, {}, 0, 0.12, 0.06, 0.10},
    {"psis", kHips, {}, 0, 0.05, 0.06, -0.11},
    {"shoulder", kLeftShoulder, {}, 0, 0.01, 0.05, 0},
    {"upper_arm", kLeftShoulder, kLeftElbow, 0.5, 0.05, 0, 0},
    {"elbow", kLeftElbow, {}, 0, 0.04, 0, 0},
    {"forearm", kLeftElbow, kLeftWrist, 0.5, 0.04, 0, 0},
    {"wrist_front", kLeftWrist, {}, 0, 0, 0, 0.035},
    {"wrist_back", kLeftWrist, {}, 0, 0, 0, -0.035},
    {"finger", kLeftWrist, {}, 0, 0.02, -0.09, 0},
    {"thigh", kLeftHip, kLeftKnee, 0.5, 0.08, 0, 0},
    {"knee", kLeftKnee, {}, 0, 0.055, 0, 0},
    {"shin", kLeftKnee, kLeftAnkle, 0.5, 0.045, 0, 0.02},
    {"ankle", kLeftAnkle, {}, 0, 0.04, 0, 0},
    {"heel", kLeftAnkle, {}, 0, 0, -0.04, -0.06},
    {"ball", kLeftToe, {}, 0, 0, 0.02, 0},
    {"outer_foot", kLeftToe, {}, 0, 0.05, 0, -0.02},
};

struct MeanPose {
  std::shared_ptr<const Skeleton> skeleton;
  WorldPose world;  // heading along +Z
};

// Quaternions that differ by half a turn at most are averaged well enough by their coordinates.
MeanPose MeanPoseOf(const std::vector<MotionClip>& clips) {
  if (clips.empty()) throw std::invalid_argument("FullBodyMarkers: no clips");
  const std::shared_ptr<const Skeleton>& skeleton = clips.front().shared_skeleton();
  if (!skeleton->roles().Missing(LocomotionRoles()).empty()) throw std::invalid_argument("FullBodyMarkers: the skeleton lacks leg joints");
  const int joints = skeleton->joint_count(), root = skeleton->moving_root();
  long long frames = 0;
  for (const MotionClip& clip : clips) frames += clip.frame_count();
  const long long stride = std::max(1LL, frames / kFramesOfMean);
  Eigen::Matrix4Xd sums = Eigen::Matrix4Xd::Zero(4, joints);
  long long n = 0;
  for (const MotionClip& clip : clips) {
    for (int f = 0; f < clip.frame_count(); ++f) {
      if (n++ % stride != 0) continue;
      const Eigen::Quaterniond level(Eigen::AngleAxisd(-HeadingRad(clip, f), Eigen::Vector3d::UnitY()));
      for (int j = 0; j < joints; ++j) {
        const Eigen::Vector4d turn = j == root ? (level * clip.rotation(f, j)).coeffs() : clip.rotation(f, j).coeffs();
        sums.col(j) += sums.col(j).dot(turn) < 0 ? Eigen::Vector4d(-turn) : turn;
      }
    }
  }
  std::vector<Eigen::Quaterniond> rotations;
  for (int j = 0; j < joints; ++j) rotations.emplace_back(Eigen::Quaterniond(Eigen::Vector4d(sums.col(j))).normalized());
  MeanPose mean;
  mean.skeleton = skeleton;
  ForwardKinematics(*skeleton, rotations.data(), Eigen::Vector3d::Zero(), &mean.world);
  return mean;
}

void Add(const MeanPose& mean, const MarkerPlace& place, const std::string& name, bool right, std::vector<Placement>* markers) {
  const auto on_side = [right](JointRole role) { return right ? MirroredRole(role) : role; };
  const RoleMap& roles = mean.skeleton->roles();
  const JointRole role = on_side(place.joint);
  if (!roles.Has(role)) return;
  const int joint = roles[role];
  const double scale = mean.skeleton->leg_length_m() / kLegLength_m;
  Eigen::Vector3d from_joint = scale * Eigen::Vector3d(right ? -place.left_m : place.left_m, place.up_m, place.forwards_m);
  if (place.towards) {
    if (!roles.Has(on_side(*place.towards))) return;
    from_joint += place.part * (mean.world.positions.col(roles[on_side(*place.towards)]) - mean.world.positions.col(joint));
  }
  Placement marker;
  marker.name = name;
  marker.joint = std::string(RoleName(role));
  marker.offset_m = mean.world.rotations[static_cast<std::size_t>(joint)].conjugate() * from_joint;
  markers->push_back(std::move(marker));
}

}  // namespace

std::vector<Placement> FullBodyMarkers(const std::vector<MotionClip>& clips) {
  const MeanPose mean = MeanPoseOf(clips);
  std::vector<Placement> markers;
  for (const MarkerPlace& place : kMiddle) Add(mean, place, place.name, false, &markers);
  for (const bool right : {false, true}) {
    for (const MarkerPlace& place : kSides) Add(mean, place, (right ? "right_" : "left_") + std::string(place.name), right, &markers);
  }
  return markers;
}

}  // namespace morphograph
