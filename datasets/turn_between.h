#pragma once

#include <Eigen/Geometry>

namespace morphograph {

/// The smallest turn that brings one direction onto another; of opposite ones, about any axis across. Behind a plain function because Eigen's
/// (a singular value decomposition, for opposite directions) takes seconds to compile wherever it is called.
Eigen::Quaterniond TurnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace morphograph
