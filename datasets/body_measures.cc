#include "datasets/body_measures.h"

#include <array>
#include <cmath>
#include <limits>

#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

constexpr double kLeg_m = 0.82;      // hip joint to ankle of a grown person
constexpr double kStature_m = 1.7;
constexpr double kLargestMisfit = 1.45;  // ratio to kLeg_m; the known units lie at least 2.2 apart
constexpr std::array<double, 5> kKnownUnits = {1, 0.01, 0.001, 0.0254, 0.0254 / 0.45};
constexpr int kSampledFrames = 50;

int First(const RoleMap& roles, std::initializer_list<JointRole> wanted) {
  for (const JointRole role : wanted) {
    if (roles.Has(role)) return roles[role];
  }
  return -1;
}

// Mean over the clip of (upper - lower) and of the body's largest extent.
struct Posture {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  double extent = 0;
};

Posture MeasurePosture(const MotionClip& clip, const Skeleton& skeleton) {
  const RoleMap& roles = skeleton.roles();
  const int left = First(roles, {JointRole::kLeftAnkle, JointRole::kLeftKnee, JointRole::kLeftToe});
  const int right = First(roles, {JointRole::kRightAnkle, JointRole::kRightKnee, JointRole::kRightToe});
  const int upper = First(roles, {JointRole::kHead, JointRole::kNeck, JointRole::kChest, JointRole::kHips});
  Posture posture;
  WorldPose pose;
  const int step = std::max(1, clip.frame_count() / kSampledFrames);
  int samples = 0;
  for (int f = 0; f < clip.frame_count(); f += step, ++samples) {
    ForwardKinematics(skeleton, clip.rotations(f), clip.root_positions().col(f), &pose);
    if (left >= 0 && right >= 0 && upper >= 0) {
      posture.up += pose.positions.col(upper) - 0.5 * (pose.positions.col(left) + pose.positions.col(right));
    }
    Eigen::Vector3d low = pose.positions.col(skeleton.moving_root());
    Eigen::Vector3d high = low;
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      if (!skeleton.IsBody(j)) continue;
      low = low.cwiseMin(pose.positions.col(j));
      high = high.cwiseMax(pose.positions.col(j));
    }
    posture.extent += (high - low).maxCoeff();
  }
  posture.up /= samples;
  posture.extent /= samples;
  return posture;
}

}  // namespace

BodyMeasures MeasureBody(const MotionClip& clip, const Skeleton& skeleton) {
  BodyMeasures measures;
  const Posture posture = MeasurePosture(clip, skeleton);

  const Eigen::Vector3d& up = posture.up;
  if (up.z() > std::abs(up.y()) && up.z() > std::abs(up.x())) {
    measures.up_axis = UpAxis::kZ;
  } else if (!(up.y() > std::abs(up.x()) && up.y() > std::abs(up.z()))) {
    measures.up_note = "up axis not found from the pose, Y taken";
  }

  const bool legs = skeleton.leg_length_m() > 0;
  const double length = legs ? skeleton.leg_length_m() : posture.extent;
  const double expected = legs ? kLeg_m : kStature_m;
  if (!(length > 1e-9)) {
    measures.unit_note = "unit not found, metres taken";
    return measures;
  }
  double best = std::numeric_limits<double>::infinity();
  for (const double unit : kKnownUnits) {
    const double misfit = std::abs(std::log(length * unit / expected));
    if (misfit < best) {
      best = misfit;
      measures.metres_per_unit = unit;
    }
  }
  if (best > std::log(kLargestMisfit)) {
    measures.metres_per_unit = expected / length;
    measures.unit_note = "no known unit fits the size of the body, scaled to a grown person's";
  }
  return measures;
}

}  // namespace morphograph
