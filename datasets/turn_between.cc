#include "datasets/turn_between.h"

namespace morphograph {

Eigen::Quaterniond TurnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) { return Eigen::Quaterniond::FromTwoVectors(from, to); }

}  // namespace morphograph
