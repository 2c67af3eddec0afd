#include "datasets/mirror.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "datasets/forward_kinematics.h"
#include "datasets/leg_ik.h"

namespace morphograph {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kSameDirection = 0.94;    // cosine between a bone and its mirrored opposite, mean; 20 degrees
constexpr double kMotionWeight = 0.2;      // of what the clip shows beside what the offsets say
constexpr double kEqualBones_m = 1e-3;     // legs that differ by less need no inverse kinematics

const Matrix3d kReflection = Vector3d(-1, 1, 1).asDiagonal();

std::string Replaced(std::string text, size_t at, size_t length, const std::string& with) {
  return text.replace(at, length, with);
}

// Names that the joint opposite to `name` may have.
std::vector<std::string> OppositeNames(const std::string& name) {
  std::vector<std::string> names;
  const std::pair<std::string, std::string> words[] = {{"Left", "Right"}, {"left", "right"}, {"LEFT", "RIGHT"}};
  for (const auto& [left, right] : words) {
    if (const size_t at = name.find(left); at != std::string::npos) names.push_back(Replaced(name, at, left.size(), right));
    if (const size_t at = name.find(right); at != std::string::npos) names.push_back(Replaced(name, at, right.size(), left));
  }
  const size_t start = name.rfind(':') == std::string::npos ? 0 : name.rfind(':') + 1;
  for (const size_t at : {start, name.size() - 1}) {
    for (const auto& [from, to] : {std::pair{'L', 'R'}, {'R', 'L'}, {'l', 'r'}, {'r', 'l'}}) {
      if (at < name.size() && name[at] == from) names.push_back(Replaced(name, at, 1, std::string(1, to)));
    }
  }
  return names;
}

std::vector<int> PairJoints(const Skeleton& skeleton) {
  const int joints = skeleton.joint_count();
  std::vector<int> pairs(joints, -1);
  for (int i = 0; i < kJointRoleCount; ++i) {
    const auto role = static_cast<JointRole>(i);
    const RoleMap& roles = skeleton.roles();
    if (roles.Has(role) && roles.Has(MirroredRole(role))) pairs[roles[role]] = roles[MirroredRole(role)];
  }
  for (int j = 0; j < joints; ++j) {
    if (pairs[j] >= 0) continue;
    for (const std::string& name : OppositeNames(skeleton.joint(j).name)) {
      const int other = skeleton.Find(name);
      if (other >= 0 && (pairs[other] < 0 || pairs[other] == j)) {
        pairs[j] = other;
        pairs[other] = j;
        break;
      }
    }
    if (pairs[j] < 0) pairs[j] = j;
  }
  for (int j = 1; j < joints; ++j) {
    const int opposite_parent = pairs[skeleton.parent(j)];
    if (opposite_parent < 0 || (pairs[j] == j && opposite_parent != skeleton.parent(j))) {
      pairs[j] = -1;
    } else if (pairs[j] >= 0 && opposite_parent != skeleton.parent(pairs[j])) {
      throw std::invalid_argument("FindMirrorMap: '" + skeleton.joint(j).name + "' and '" + skeleton.joint(pairs[j]).name +
                                  "' do not hang in the same place of the left and right half");
    }
  }
  return pairs;
}

// Sum of u v^T over the bones that start at a joint and their opposites, as unit vectors u and v in their joints' own axes.
struct BoneMatch {
  Matrix3d sum = Matrix3d::Zero();
  double count = 0;  // trace of `sum` turned by a perfect correspondence
};

BoneMatch MatchBones(const Skeleton& skeleton, const std::vector<int>& pairs, int joint) {
  BoneMatch match;
  const auto add = [&match](const Vector3d& here, const Vector3d& there) {
    if (here.norm() < 1e-6 || there.norm() < 1e-6) return;
    match.sum += here.normalized() * there.normalized().transpose();
    match.count += 1;
  };
  for (int c = joint + 1; c < skeleton.joint_count(); ++c) {
    if (skeleton.parent(c) != joint || pairs[c] < 0) continue;
    add(skeleton.joint(c).offset_m, skeleton.joint(pairs[c]).offset_m);
  }
  const auto& here = skeleton.joint(joint).end_site_m;
  const auto& there = skeleton.joint(pairs[joint]).end_site_m;
  if (here && there) add(*here, *there);
  return match;
}

// The orthogonal matrix of determinant -1 nearest to `match` (Kabsch's solution with the sign turned over).
Matrix3d NearestImproper(const Matrix3d& match) {
  const Eigen::JacobiSVD<Matrix3d> svd(match, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Vector3d(1, 1, sign > 0 ? -1 : 1).asDiagonal() * svd.matrixV().transpose();
}

// The signed permutation of determinant -1 that agrees best with `match` among those that send bones to their opposites, if any does;
// on the midline it must be its own inverse.
std::optional<Matrix3d> AxisAligned(const BoneMatch& bones, const Matrix3d& match, bool midline) {
  std::optional<Matrix3d> best;
  double best_agreement = 0;
  Eigen::PermutationMatrix<3> permutation;
  int order[3] = {0, 1, 2};
  do {
    permutation.indices() = Eigen::Vector3i(order[0], order[1], order[2]);
    for (int signs = 0; signs < 8; ++signs) {
      const Vector3d sign(signs & 1 ? -1 : 1, signs & 2 ? -1 : 1, signs & 4 ? -1 : 1);
      const Matrix3d candidate = permutation.toDenseMatrix().cast<double>() * sign.asDiagonal();
      if (candidate.determinant() > 0 || (midline && !candidate.isApprox(candidate.transpose()))) continue;
      if ((candidate.transpose() * bones.sum).trace() < kSameDirection * bones.count) continue;
      const double agreement = (candidate.transpose() * match).trace();
      if (best && agreement <= best_agreement + 1e-9) continue;
      best = candidate;
      best_agreement = agreement;
    }
  } while (std::next_permutation(order, order + 3));
  return best;
}

// A reflection in a plane: the symmetric matrix of determinant -1 nearest to one that should be.
Matrix3d NearestReflection(const Matrix3d& turn) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(0.5 * (turn + turn.transpose()));
  const Vector3d normal = eigen.eigenvectors().col(0);  // of the least eigenvalue
  return Matrix3d::Identity() - 2 * normal * normal.transpose();
}

// Across the hips in the moving root's own frame, mean of the clip.
Vector3d AcrossRoot(const MotionClip& clip) {
  const RoleMap& roles = clip.skeleton().roles();
  Vector3d across = Vector3d::Zero();
  if (roles.Has(JointRole::kLeftHip) && roles.Has(JointRole::kRightHip)) {
    const WorldPose pose = ForwardKinematics(clip, 0);
    across = pose.positions.col(roles[JointRole::kLeftHip]) - pose.positions.col(roles[JointRole::kRightHip]);
    across = pose.rotations[clip.skeleton().moving_root()].conjugate() * across;
  }
  return across.norm() > 1e-6 ? Vector3d(across.normalized()) : Vector3d::UnitX();
}

}  // namespace

MirrorMap FindMirrorMap(const MotionClip& clip) {
  const Skeleton& skeleton = clip.skeleton();
  const int joints = skeleton.joint_count();
  MirrorMap map;
  map.pairs = PairJoints(skeleton);
  map.turns.assign(joints, kReflection);

  std::vector<Matrix3d> mean(joints, Matrix3d::Zero());  // of the local rotations
  const int stride = std::max(1, clip.frame_count() / 200);
  for (int f = 0; f < clip.frame_count(); f += stride) {
    for (int j = 0; j < joints; ++j) mean[j] += clip.rotation(f, j).toRotationMatrix();
  }
  const Vector3d across = clip.frame_count() > 0 ? AcrossRoot(clip) : Vector3d::UnitX();
  for (int j = 0; j < joints; ++j) {
    if (!skeleton.IsBody(j) || map.pairs[j] < j) continue;  // no opposite joint, or it came first
    const int other = map.pairs[j];
    BoneMatch bones = MatchBones(skeleton, map.pairs, j);
    Matrix3d match;
    if (j == skeleton.moving_root()) {
      bones.sum += Matrix3d::Identity() - 2 * across * across.transpose();
      bones.count += 3;
      match = bones.sum;
    } else {
      // Mirrored local rotation of the opposite joint: B_parent^T q_j B_j; over the clip it should be like that joint's own.
      const Matrix3d wanted = mean[j].transpose() * map.turns[skeleton.parent(j)] * mean[other];
      const double size = wanted.norm();
      match = bones.sum;
      if (size > 1e-12) match += kMotionWeight * std::sqrt(3.0) / size * wanted;
    }
    const bool midline = other == j;
    const std::optional<Matrix3d> aligned = AxisAligned(bones, match, midline);
    const Matrix3d nearest = NearestImproper(match);
    map.turns[j] = aligned ? *aligned : midline ? NearestReflection(nearest) : nearest;
    map.turns[other] = map.turns[j].transpose().eval();  // both are one on the midline
  }
  return map;
}

MotionClip Mirrored(const MotionClip& clip, const MirrorMap& map) {
  const Skeleton& skeleton = clip.skeleton();
  const int joints = skeleton.joint_count();
  if (static_cast<int>(map.pairs.size()) != joints || static_cast<int>(map.turns.size()) != joints) {
    throw std::invalid_argument("Mirrored: the map is for " + std::to_string(map.pairs.size()) + " joints, the skeleton has " +
                                std::to_string(joints));
  }
  MotionClip mirrored = clip;
  mirrored.name = clip.name + "_mirrored";
  const int root = skeleton.moving_root();
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < joints; ++j) {
      if (!skeleton.IsBody(j) || map.pairs[j] < 0) continue;
      const Matrix3d parent_turn = j == root ? kReflection : Matrix3d(map.turns[skeleton.parent(j)].transpose());
      mirrored.rotation(f, map.pairs[j]) =
          Quaterniond(Matrix3d(parent_turn * clip.rotation(f, j).toRotationMatrix() * map.turns[j])).normalized();
    }
    mirrored.root_positions()(0, f) = -clip.root_positions()(0, f);
  }

  if (!skeleton.roles().Missing(LocomotionRoles()).empty()) return mirrored;
  const LegIk legs[] = {LegIk(skeleton, Foot::kLeft), LegIk(skeleton, Foot::kRight)};
  double unequal = 0;
  for (int j = 0; j < joints; ++j) {
    if (j != root && skeleton.IsBody(j) && map.pairs[j] >= 0) {
      unequal = std::max(unequal, (skeleton.joint(j).offset_m - map.turns[skeleton.parent(j)] * skeleton.joint(map.pairs[j]).offset_m).norm());
    }
  }
  if (unequal < kEqualBones_m) return mirrored;
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int side = 0; side < 2; ++side) {
      const LegMeasure opposite = legs[1 - side].Measure(clip.root_positions().col(f), clip.rotations(f));
      legs[side].Solve(kReflection * opposite.ankle_m, std::nullopt, mirrored.root_positions().col(f), &mirrored.rotation(f, 0));
    }
  }
  return mirrored;
}

MotionClip Mirrored(const MotionClip& clip) { return Mirrored(clip, FindMirrorMap(clip)); }

}  // namespace morphograph
