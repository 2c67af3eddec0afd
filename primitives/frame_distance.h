#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/skeleton.h"

namespace morphograph {

/// A turn about +Y followed by a move over the floor: p -> R_y(yaw) p + (x, 0, z), with
/// R_y(yaw) taking +Z to (sin yaw, 0, cos yaw). So yaw adds to a heading (0 along +Z, pi/2 along +X).
struct PlanarTransform {
  double yaw_rad = 0;
  double x_m = 0;
  double z_m = 0;

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const;
};

/// Weighted squared distance of two poses, after the best turn and move of `b` on the floor (Du Eq. 3.1).
///
/// Closed form (Du Eq. 3.5-3.7), with atan2: the printed arctan loses the half-plane. Du's Eq. 3.5-3.7 belong to
/// the rotation used here; the matrix printed in Eq. 3.2 and 3.4 turns the other way round. Does not allocate.
///
/// @param a, b  joint positions (3 x joints), metres, Y up.
/// @param weights  (joints) >= 0 with a positive sum; with sum 1 the result is a mean squared distance in m^2.
/// @param best  if given, the transform T for which T b comes closest to a.
/// @return squared metres times weight, >= 0. Symmetric in a and b.
/// @throws std::invalid_argument when sizes differ or the weights do not have a positive sum.
double FrameDistance(const Eigen::Ref<const Eigen::Matrix3Xd>& a, const Eigen::Ref<const Eigen::Matrix3Xd>& b,
                     const Eigen::Ref<const Eigen::VectorXd>& weights, PlanarTransform* best = nullptr);

/// Frame distances of all pairs, (reference frames x test frames): the cost matrix of DynamicTimeWarp.
/// Several times faster than pair by pair, since each frame is centred once.
Eigen::MatrixXd FrameDistanceMatrix(const std::vector<Eigen::Matrix3Xd>& reference,
                                    const std::vector<Eigen::Matrix3Xd>& test, const Eigen::VectorXd& weights);

/// Joint weights that fall with depth in the hierarchy, 1 / (1 + depth) below the moving root (Du 3.2.1:
/// noise is heaviest at the leaves), with sum 1.
///
/// Departures: joints above the moving root stand still and weigh nothing; a joint without bone (zero offset,
/// as cmu's LHipJoint) is its parent's point again, so it weighs nothing and adds no depth.
Eigen::VectorXd FrameDistanceWeights(const Skeleton& skeleton);

}  // namespace morphograph
