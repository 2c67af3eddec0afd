#include "primitives/frame_distance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

void CheckWeights(Eigen::Index joints, const Eigen::Ref<const Eigen::VectorXd>& weights) {
  if (weights.size() != joints)
    throw std::invalid_argument("FrameDistance: " + std::to_string(weights.size()) + " weights for " +
                                std::to_string(joints) + " joints");
  if (!(weights.sum() > 0) || !(weights.minCoeff() >= 0))
    throw std::invalid_argument("FrameDistance: weights must be >= 0 and have a positive sum");
}

// Frames with the weighted mean of x and z taken out and every coordinate times sqrt(weight).
// One frame a column: all x, then all z, then all y, so that products over joints are dot products.
struct CentredFrames {
  Eigen::MatrixXd columns;         // (3 joints x frames)
  Eigen::VectorXd squared_length;  // of each column
};

CentredFrames Centre(const std::vector<Eigen::Matrix3Xd>& frames, const Eigen::VectorXd& weights) {
  const Eigen::Index joints = weights.size();
  const Eigen::VectorXd root_weights = weights.cwiseSqrt();
  CentredFrames out;
  out.columns.resize(3 * joints, static_cast<Eigen::Index>(frames.size()));
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const Eigen::Matrix3Xd& p = frames[f];
    if (p.cols() != joints)
      throw std::invalid_argument("FrameDistanceMatrix: frame " + std::to_string(f) + " has " + std::to_string(p.cols()) +
                                  " joints, not " + std::to_string(joints));
    const double total = weights.sum();
    const double mean_x = p.row(0).dot(weights) / total;
    const double mean_z = p.row(2).dot(weights) / total;
    auto column = out.columns.col(static_cast<Eigen::Index>(f));
    column.head(joints) = (p.row(0).transpose().array() - mean_x) * root_weights.array();
    column.segment(joints, joints) = (p.row(2).transpose().array() - mean_z) * root_weights.array();
    column.tail(joints) = p.row(1).transpose().array() * root_weights.array();
  }
  out.squared_length = out.columns.colwise().squaredNorm().transpose();
  return out;
}

}  // namespace

Eigen::Vector3d PlanarTransform::operator*(const Eigen::Vector3d& point) const {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * point.x() + s * point.z() + x_m, point.y(), -s * point.x() + c * point.z() + z_m};
}

double FrameDistance(const Eigen::Ref<const Eigen::Matrix3Xd>& a, const Eigen::Ref<const Eigen::Matrix3Xd>& b,
                     const Eigen::Ref<const Eigen::VectorXd>& weights, PlanarTransform* best) {
  const Eigen::Index joints = a.cols();
  if (b.cols() != joints)
    throw std::invalid_argument("FrameDistance: poses of " + std::to_string(joints) + " and " + std::to_string(b.cols()) +
                                " joints");
  CheckWeights(joints, weights);

  double total = 0, ax = 0, az = 0, bx = 0, bz = 0;
  for (Eigen::Index i = 0; i < joints; ++i) {
    const double w = weights[i];
    total += w;
    ax += w * a(0, i);
    az += w * a(2, i);
    bx += w * b(0, i);
    bz += w * b(2, i);
  }
  ax /= total;
  az /= total;
  bx /= total;
  bz /= total;

  // With x, z and x', z' measured from their weighted means, the sum over joints is
  // rest - 2 (cosine_sum cos(yaw) + sine_sum sin(yaw)), which is least at yaw = atan2 and there rest - 2 hypot.
  double rest = 0, cosine_sum = 0, sine_sum = 0;
  for (Eigen::Index i = 0; i < joints; ++i) {
    const double w = weights[i];
    const double x = a(0, i) - ax, z = a(2, i) - az;
    const double u = b(0, i) - bx, v = b(2, i) - bz;
    const double dy = a(1, i) - b(1, i);
    rest += w * (x * x + z * z + u * u + v * v + dy * dy);
    cosine_sum += w * (x * u + z * v);
    sine_sum += w * (x * v - z * u);
  }
  if (best) {
    best->yaw_rad = std::atan2(sine_sum, cosine_sum);                           // Eq. 3.5
    const double c = std::cos(best->yaw_rad), s = std::sin(best->yaw_rad);
    best->x_m = ax - bx * c - bz * s;                                           // Eq. 3.6
    best->z_m = az + bx * s - bz * c;                                           // Eq. 3.7
  }
  // Rounding may leave a tiny negative number where the poses are the same.
  return std::max(0.0, rest - 2 * std::sqrt(cosine_sum * cosine_sum + sine_sum * sine_sum));
}

Eigen::MatrixXd FrameDistanceMatrix(const std::vector<Eigen::Matrix3Xd>& reference,
                                    const std::vector<Eigen::Matrix3Xd>& test, const Eigen::VectorXd& weights) {
  CheckWeights(weights.size(), weights);
  const CentredFrames a = Centre(reference, weights), b = Centre(test, weights);
  const Eigen::Index n = weights.size();
  const Eigen::MatrixXd cosine_sum = a.columns.topRows(2 * n).transpose() * b.columns.topRows(2 * n);
  const Eigen::MatrixXd height = a.columns.bottomRows(n).transpose() * b.columns.bottomRows(n);
  const Eigen::MatrixXd sine_sum = a.columns.topRows(n).transpose() * b.columns.middleRows(n, n) -
                                   a.columns.middleRows(n, n).transpose() * b.columns.topRows(n);
  Eigen::MatrixXd distances =
      -2.0 * (height.array() + (cosine_sum.array().square() + sine_sum.array().square()).sqrt()).matrix();
  distances.colwise() += a.squared_length;
  distances.rowwise() += b.squared_length.transpose();
  return distances.cwiseMax(0.0);
}

Eigen::VectorXd FrameDistanceWeights(const Skeleton& skeleton) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(skeleton.joint_count());
  std::vector<int> depth(static_cast<std::size_t>(skeleton.joint_count()), 0);
  for (int i = 0; i < skeleton.joint_count(); ++i) {
    if (!skeleton.IsBody(i)) continue;
    if (i != skeleton.moving_root()) {
      const bool has_bone = skeleton.joint(i).offset_m.norm() > 1e-6;
      depth[i] = depth[skeleton.parent(i)] + (has_bone ? 1 : 0);
      if (!has_bone) continue;
    }
    weights[i] = 1.0 / (1.0 + depth[i]);
  }
  return weights / weights.sum();
}

}  // namespace morphograph
