#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <random>

namespace morphograph::testing {

/// Independent standard normal numbers, drawn column by column.
inline Eigen::MatrixXd RandomNormal(Eigen::Index rows, Eigen::Index columns, std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  Eigen::MatrixXd out(rows, columns);
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) out(i, j) = normal(rng);
  return out;
}

inline double RandomUniform(double low, double high, std::mt19937_64& rng) {
  return boost::random::uniform_real_distribution<double>(low, high)(rng);
}

/// Uniformly distributed unit quaternion.
inline Eigen::Quaterniond RandomRotation(std::mt19937_64& rng) {
  const Eigen::Vector4d q = RandomNormal(4, 1, rng);
  return Eigen::Quaterniond(q.normalized());
}

}  // namespace morphograph::testing
