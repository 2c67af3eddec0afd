#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace morphograph {

/// Intrinsic axis order: R = R(first) R(second) R(third), axes 0 = X, 1 = Y, 2 = Z, all different.
using EulerOrder = std::array<int, 3>;

/// Angles (radians, in the order of the axes) of a rotation, the one of all equivalent triples that lies nearest
/// to `previous`, so that tracks run on through +-180 degrees. At gimbal lock, where only the sum or the
/// difference of the outer angles counts, the third angle stays what it was.
Eigen::Vector3d EulerNear(const Eigen::Quaterniond& rotation, const EulerOrder& order,
                          const Eigen::Vector3d& previous);

/// Unit quaternion of intrinsic angles (radians).
Eigen::Quaterniond QuaternionFromEuler(const Eigen::Vector3d& angles, const EulerOrder& order);

}  // namespace morphograph
