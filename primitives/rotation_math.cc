#include "primitives/rotation_math.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace morphograph {
namespace {

// Above this squared half angle, (pi/2)^2 and a little, the series below lose digits.
constexpr double kSeriesLimit = 2.5;

// Rotations by less than 0.8 rad, nearly all of them about a mean, need fewer terms.
constexpr double kShortSeriesLimit = 0.16;

// sin(h) / h and cos(h) from h^2, Taylor in Horner form. First omitted terms with 10 terms at h^2 = 2.5: 2.5^11 / 23! = 9e-19 and
// 2.5^11 / 22! = 2e-17; with 6 terms at h^2 = 0.16: 0.16^7 / 15! = 2e-18 and 0.16^7 / 14! = 3e-17.
template <int kTerms>
double SincSeries(double h2) {
  double s = 1.0;
  for (int n = kTerms; n >= 1; --n) s = 1.0 - s * h2 * (1.0 / ((2.0 * n) * (2.0 * n + 1.0)));
  return s;
}

template <int kTerms>
double CosSeries(double h2) {
  double c = 1.0;
  for (int n = kTerms; n >= 1; --n) c = 1.0 - c * h2 * (1.0 / ((2.0 * n - 1.0) * (2.0 * n)));
  return c;
}

}  // namespace

Eigen::Quaterniond ExpMap(const Eigen::Vector3d& rotation_vector) {
  const double h2 = 0.25 * rotation_vector.squaredNorm();
  double w, half_sinc;
  if (h2 <= kShortSeriesLimit) {
    w = CosSeries<6>(h2);
    half_sinc = 0.5 * SincSeries<6>(h2);
  } else if (h2 <= kSeriesLimit) {
    w = CosSeries<10>(h2);
    half_sinc = 0.5 * SincSeries<10>(h2);
  } else {
    const double h = std::sqrt(h2);
    w = std::cos(h);
    half_sinc = 0.5 * std::sin(h) / h;
  }
  return Eigen::Quaterniond(w, half_sinc * rotation_vector.x(), half_sinc * rotation_vector.y(),
                            half_sinc * rotation_vector.z());
}

Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& rotation_vector) {
  const double angle2 = rotation_vector.squaredNorm();
  Eigen::Matrix3d cross;
  cross << 0, -rotation_vector.z(), rotation_vector.y(), rotation_vector.z(), 0, -rotation_vector.x(), -rotation_vector.y(),
      rotation_vector.x(), 0;
  // (1 - cos a) / a^2 and (a - sin a) / a^3, by their series where these would cancel.
  double first = 0.5 - angle2 / 24, second = 1.0 / 6 - angle2 / 120;
  if (angle2 > 1e-6) {
    const double angle = std::sqrt(angle2);
    first = (1 - std::cos(angle)) / angle2;
    second = (angle - std::sin(angle)) / (angle2 * angle);
  }
  return Eigen::Matrix3d::Identity() - first * cross + second * cross * cross;
}

Eigen::Vector3d LogMap(const Eigen::Quaterniond& rotation) {
  // Of q and -q, the one with w >= 0 turns by at most pi.
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const double w = sign * rotation.w();
  const Eigen::Vector3d v = sign * rotation.vec();
  const double s2 = v.squaredNorm();
  double angle_over_sine;
  if (s2 < 1e-10 * w * w) {
    // 2 atan(s/w) / s = 2/w (1 - (s/w)^2 / 3 + ...); the next term is below 1e-20.
    angle_over_sine = 2.0 / w * (1.0 - s2 / (3.0 * w * w));
  } else {
    const double s = std::sqrt(s2);
    angle_over_sine = 2.0 * std::atan2(s, w) / s;
  }
  return angle_over_sine * v;
}

Eigen::Vector3d LogMapAbout(const Eigen::Quaterniond& mean, const Eigen::Quaterniond& rotation) {
  return LogMap(mean.conjugate() * rotation);
}

Eigen::Quaterniond ExpMapAbout(const Eigen::Quaterniond& mean, const Eigen::Vector3d& rotation_vector) {
  return mean * ExpMap(rotation_vector);
}

Eigen::Quaterniond GeodesicMean(const std::vector<Eigen::Quaterniond>& rotations) {
  if (rotations.empty()) throw std::invalid_argument("GeodesicMean: no rotations given");
  Eigen::Matrix4d outer = Eigen::Matrix4d::Zero();
  for (const Eigen::Quaterniond& q : rotations) outer += q.coeffs() * q.coeffs().transpose();  // x, y, z, w
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(outer);
  Eigen::Quaterniond mean(Eigen::Vector4d(eigen.eigenvectors().col(3)));
  // A few iterations suffice where rotations lie within a half-turn of each other; the cap is for the rest.
  for (int iteration = 0; iteration < 100; ++iteration) {
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    for (const Eigen::Quaterniond& q : rotations) step += LogMapAbout(mean, q);
    step /= static_cast<double>(rotations.size());
    mean = ExpMapAbout(mean, step).normalized();
    if (step.squaredNorm() < 1e-26) break;
  }
  if (mean.w() < 0) mean.coeffs() = -mean.coeffs();
  return mean;
}

}  // namespace morphograph
