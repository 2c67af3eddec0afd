#include "datasets/euler.h"

#include <cmath>
#include <numbers>

namespace morphograph {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTwoPi = 2 * std::numbers::pi;
// Below this cosine of the middle angle the outer two cannot be told apart in double precision; holding the
// third one then costs less than 1e-5 degrees.
constexpr double kGimbalCosine = 1e-7;

double NearestTurn(double angle, double target) {
  const double gap = target - angle;
  return std::abs(gap) <= kPi ? angle : angle + kTwoPi * std::round(gap / kTwoPi);
}

Eigen::Vector3d NearestTurns(const Eigen::Vector3d& angles, const Eigen::Vector3d& target) {
  return {NearestTurn(angles[0], target[0]), NearestTurn(angles[1], target[1]), NearestTurn(angles[2], target[2])};
}

}  // namespace

Eigen::Vector3d EulerNear(const Eigen::Quaterniond& rotation, const EulerOrder& order,
                          const Eigen::Vector3d& previous) {
  const auto [i, j, k] = order;
  const double sign = (j - i + 3) % 3 == 1 ? 1 : -1;  // X Y Z and its cycles: +1
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  const double cosine = std::sqrt(r(i, i) * r(i, i) + r(i, j) * r(i, j));
  if (cosine < kGimbalCosine) {
    // With the third angle given, R R(third)^-1 = R(first) R(second) yields the other two.
    const Eigen::Matrix3d rest = r * Eigen::AngleAxisd(-previous[2], Eigen::Vector3d::Unit(k)).toRotationMatrix();
    const Eigen::Vector3d angles(std::atan2(sign * rest(k, j), rest(j, j)),
                                 std::atan2(sign * rest(i, k), rest(i, i)), previous[2]);
    return NearestTurns(angles, previous);
  }
  const Eigen::Vector3d angles(std::atan2(-sign * r(j, k), r(k, k)), std::atan2(sign * r(i, k), cosine),
                               std::atan2(-sign * r(i, j), r(i, i)));
  const Eigen::Vector3d one = NearestTurns(angles, previous);
  // The other triple differs by half a turn in two angles, so it cannot be nearer than this.
  if ((one - previous).squaredNorm() <= kPi * kPi / 2) return one;
  const Eigen::Vector3d other = NearestTurns({angles[0] + kPi, kPi - angles[1], angles[2] + kPi}, previous);
  return (one - previous).squaredNorm() <= (other - previous).squaredNorm() ? one : other;
}

Eigen::Quaterniond QuaternionFromEuler(const Eigen::Vector3d& angles, const EulerOrder& order) {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (int i = 0; i < 3; ++i) rotation = rotation * Eigen::AngleAxisd(angles[i], Eigen::Vector3d::Unit(order[i]));
  return rotation;
}

}  // namespace morphograph
