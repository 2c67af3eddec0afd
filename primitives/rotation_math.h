#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace morphograph {

/// Rotation of `rotation_vector` (axis times angle, radians) as a unit quaternion.
///
/// Needs neither a square root nor sine and cosine up to an angle of pi: both half-angle
/// functions are even, so they are series in the squared angle, exact to rounding there.
/// Larger angles are taken by the library functions.
Eigen::Quaterniond ExpMap(const Eigen::Vector3d& rotation_vector);

/// Inverse of ExpMap: the shortest rotation vector, |v| <= pi; q and -q give the same.
/// @param rotation  unit quaternion (its length cancels, so slight drift does no harm).
Eigen::Vector3d LogMap(const Eigen::Quaterniond& rotation);

/// Right Jacobian of the exponential map: ExpMap(v + d) = ExpMap(v) ExpMap(RightJacobian(v) d) for small d (Sola et al. 2018,
/// A micro Lie theory, Eq. 143).
Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& rotation_vector);

/// Log map of `rotation` about `mean`: LogMap(mean^-1 rotation), a vector in the mean's own frame.
Eigen::Vector3d LogMapAbout(const Eigen::Quaterniond& mean, const Eigen::Quaterniond& rotation);
/// Inverse of LogMapAbout.
Eigen::Quaterniond ExpMapAbout(const Eigen::Quaterniond& mean, const Eigen::Vector3d& rotation_vector);

/// Geodesic (Karcher) mean: the rotation whose squared angles to all the given ones sum to the least.
///
/// Starts from the leading eigenvector of the sum of q q^T (Markley et al. 2007), which does not care
/// about the signs of the quaternions, and then iterates the mean of the logs. Returned with w >= 0.
/// @throws std::invalid_argument when `rotations` is empty.
Eigen::Quaterniond GeodesicMean(const std::vector<Eigen::Quaterniond>& rotations);

}  // namespace morphograph
