#include "synthesis/smoothness.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace morphograph {
namespace {

std::vector<int> RoleJoints(const Skeleton& skeleton) {
  std::vector<int> joints;
  for (const JointRole role : EvaluationRoles()) {
    if (skeleton.roles().Has(role)) joints.push_back(skeleton.roles()[role]);
  }
  return joints;
}

}  // namespace

std::vector<double> JointAccelerations(const Skeleton& skeleton,
                                       const std::vector<Eigen::Matrix3Xd>& joint_positions,
                                       double frame_rate_hz) {
  const double scale = frame_rate_hz * frame_rate_hz;
  const std::vector<int> joints = RoleJoints(skeleton);
  std::vector<double> norms;
  for (size_t f = 2; f < joint_positions.size(); ++f) {
    for (const int j : joints) {
      norms.push_back(scale * (joint_positions[f].col(j) - 2 * joint_positions[f - 1].col(j) +
                               joint_positions[f - 2].col(j))
                                  .norm());
    }
  }
  return norms;
}

std::vector<double> JointJerks(const Skeleton& skeleton, const std::vector<Eigen::Matrix3Xd>& joint_positions,
                               double frame_rate_hz) {
  const double scale = frame_rate_hz * frame_rate_hz * frame_rate_hz;
  const std::vector<int> joints = RoleJoints(skeleton);
  std::vector<double> norms;
  for (size_t f = 3; f < joint_positions.size(); ++f) {
    for (const int j : joints) {
      norms.push_back(scale * (joint_positions[f].col(j) - 3 * joint_positions[f - 1].col(j) +
                               3 * joint_positions[f - 2].col(j) - joint_positions[f - 3].col(j))
                                  .norm());
    }
  }
  return norms;
}

}  // namespace morphograph
