#include "primitives/pose_window.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

constexpr Eigen::Index kPoses = 3;  // in a window
// Scatter that any joint may have within a kind, as part of the mean one: few examples can agree by chance.
constexpr double kLeastScatter = 0.01;

Eigen::Matrix3Xd PoseAt(const std::vector<Eigen::Matrix3Xd>& poses, double frame) {
  const int last = static_cast<int>(poses.size()) - 1;
  if (last == 0) return poses[0];
  const int a = std::clamp(static_cast<int>(std::floor(frame)), 0, last - 1);
  return poses[a] + (frame - a) * (poses[a + 1] - poses[a]);
}

// Centred on the floor, and turned so that the body's left side is on +X in the middle pose.
Eigen::Matrix3Xd Facing(const Eigen::Matrix3Xd& window) {
  const Eigen::Index middle = window.cols() / kPoses * (kPoses / 2);
  const Eigen::Vector3d across =
      window.col(middle + PoseColumn(JointRole::kLeftHip)) - window.col(middle + PoseColumn(JointRole::kRightHip));
  const double length = std::hypot(across.x(), across.z());
  const double c = length > 0 ? across.x() / length : 1, s = length > 0 ? across.z() / length : 0;
  Eigen::Matrix3Xd turned = window;
  const Eigen::ArrayXd x = window.row(0).array() - window.row(0).mean(), z = window.row(2).array() - window.row(2).mean();
  turned.row(0) = (c * x + s * z).matrix().transpose();
  turned.row(2) = (c * z - s * x).matrix().transpose();
  return turned;
}

// Sum over windows of every point's squared distance from its mean place.
Eigen::VectorXd Scatter(const std::vector<Eigen::Matrix3Xd>& windows) {
  std::vector<Eigen::Matrix3Xd> turned;
  Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Zero(3, windows[0].cols());
  for (const Eigen::Matrix3Xd& window : windows) {
    turned.push_back(Facing(window));
    mean += turned.back();
  }
  mean /= static_cast<double>(windows.size());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mean.cols());
  for (const Eigen::Matrix3Xd& window : turned) sum += (window - mean).colwise().squaredNorm().transpose();
  return sum;
}

}  // namespace

Eigen::Index PoseColumn(JointRole role) {
  const std::vector<JointRole>& roles = EvaluationRoles();
  return std::find(roles.begin(), roles.end(), role) - roles.begin();
}

std::vector<Eigen::Matrix3Xd> ScaledPoses(const MotionClip& clip) {
  const std::vector<JointRole>& roles = EvaluationRoles();
  const std::vector<std::string> missing = clip.skeleton().roles().Missing(roles);
  const double leg = clip.skeleton().leg_length_m();
  if (!missing.empty() || !(leg > 0)) {
    throw std::invalid_argument("ScaledPoses: the skeleton of '" + clip.name + "' has no " +
                                (missing.empty() ? std::string("leg bones") : "joint for " + missing.front()));
  }
  std::vector<Eigen::Matrix3Xd> poses;
  poses.reserve(clip.frame_count());
  for (const Eigen::Matrix3Xd& all : JointPositions(clip)) {
    Eigen::Matrix3Xd pose(3, static_cast<Eigen::Index>(roles.size()));
    for (size_t i = 0; i < roles.size(); ++i) {
      pose.col(static_cast<Eigen::Index>(i)) = all.col(clip.skeleton().roles()[roles[i]]) / leg;
    }
    poses.push_back(std::move(pose));
  }
  return poses;
}

std::vector<Eigen::Matrix3Xd> MirroredPoses(const std::vector<Eigen::Matrix3Xd>& poses) {
  const std::vector<JointRole>& roles = EvaluationRoles();
  std::vector<Eigen::Matrix3Xd> mirrored = poses;
  for (size_t f = 0; f < poses.size(); ++f) {
    for (size_t i = 0; i < roles.size(); ++i) {
      mirrored[f].col(PoseColumn(MirroredRole(roles[i]))) = poses[f].col(static_cast<Eigen::Index>(i));
    }
    mirrored[f].row(0) *= -1;
  }
  return mirrored;
}

Eigen::Matrix3Xd PoseWindow(const std::vector<Eigen::Matrix3Xd>& poses, double frame, double reach_frames) {
  const Eigen::Index joints = poses[0].cols();
  Eigen::Matrix3Xd window(3, kPoses * joints);
  for (Eigen::Index i = 0; i < kPoses; ++i) {
    window.middleCols(i * joints, joints) = PoseAt(poses, frame + static_cast<double>(i - 1) * reach_frames);
  }
  window.row(1).array() -= window.row(1).minCoeff();
  return window;
}

Eigen::VectorXd DiscriminantWeights(const std::vector<std::vector<Eigen::Matrix3Xd>>& kinds,
                                    const std::vector<Eigen::Matrix3Xd>& all) {
  const Eigen::VectorXd total = Scatter(all) / static_cast<double>(all.size());
  Eigen::VectorXd within = Eigen::VectorXd::Zero(total.size());
  double count = 0;
  for (const std::vector<Eigen::Matrix3Xd>& windows : kinds) {
    if (windows.empty()) continue;
    within += Scatter(windows);
    count += static_cast<double>(windows.size());
  }
  within /= count;
  Eigen::VectorXd weights = (total.array() / (within.array() + kLeastScatter * total.mean()) - 1).max(0.0).matrix();
  if (!(weights.sum() > 0)) weights.setOnes();
  return weights / weights.sum();
}

}  // namespace morphograph
