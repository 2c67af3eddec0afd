#include "synthesis/toe_bend.h"

#include <algorithm>
#include <cmath>

#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

constexpr double kDeepest_m = -0.005;
constexpr double kSoftness_m = 0.003;  // of the bend's onset

// Above the limit by itself far above it, never below it, smooth in between.
double SoftlyAbove(double height) {
  const double above = (height - kDeepest_m) / kSoftness_m;
  return above > 30 ? height : kDeepest_m + kSoftness_m * std::log1p(std::exp(above));
}

}  // namespace

void BendToes(MotionClip* clip) {
  const Skeleton& skeleton = clip->skeleton();
  std::vector<int> toes;
  for (const JointRole role : {JointRole::kLeftToe, JointRole::kRightToe}) {
    const int toe = skeleton.roles()[role];
    if (toe >= 0 && skeleton.joint(toe).end_site_m && skeleton.joint(toe).end_site_m->norm() > 1e-3) toes.push_back(toe);
  }
  if (toes.empty()) return;
  WorldPose pose;
  for (int f = 0; f < clip->frame_count(); ++f) {
    ForwardKinematics(skeleton, clip->rotations(f), clip->root_positions().col(f), &pose);
    for (const int toe : toes) {
      const Eigen::Vector3d along = pose.rotations[toe] * *skeleton.joint(toe).end_site_m;
      const double length = along.norm(), joint_height = pose.positions(1, toe);
      const double height = joint_height + along.y(), wanted = SoftlyAbove(height);
      if (wanted - height < 1e-6) continue;
      const Eigen::Vector3d axis = along.cross(Eigen::Vector3d::UnitY());
      if (axis.norm() < 1e-6 * length) continue;  // straight down: no way to bend is better than another
      const auto pitch = [&](double y) { return std::asin(std::clamp((y - joint_height) / length, -1.0, 1.0)); };
      const Eigen::Quaterniond up(Eigen::AngleAxisd(pitch(wanted) - pitch(height), axis.normalized()));
      const Eigen::Quaterniond& parent = pose.rotations[skeleton.parent(toe)];
      clip->rotation(f, toe) = (parent.conjugate() * up * pose.rotations[toe]).normalized();
    }
  }
}

}  // namespace morphograph
