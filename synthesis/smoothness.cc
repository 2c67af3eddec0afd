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

double Percentile(std::vector<double> values, double q) {
  if (values.empty()) throw std::invalid_argument("Percentile: no value given");
  if (!(q >= 0 && q <= 1)) throw std::invalid_argument("Percentile: fraction outside [0, 1]");
  const double place = q * static_cast<double>(values.size() - 1);
  const size_t below = static_cast<size_t>(place);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(below), values.end());
  const double low = values[below];
  if (below + 1 == values.size()) return low;
  const double high =
      *std::min_element(values.begin() + static_cast<std::ptrdiff_t>(below) + 1, values.end());
  return low + (place - static_cast<double>(below)) * (high - low);
}

}  // namespace morphograph
