#include "synthesis/window_space.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "primitives/matrix_factors.h"
#include "synthesis/frechet_distance.h"

namespace morphograph {

WindowSpace::WindowSpace(const Eigen::MatrixXd& windows, int directions) {
  if (directions < 1) throw std::invalid_argument("WindowSpace: at least one direction is needed");
  const GaussianFit fit = FitGaussian(windows);
  // Through the covariance, not the SVD of the windows: 220 dimensions against tens of thousands of windows,
  // and only the leading directions matter, which the squared condition number does not hurt.
  const SymmetricFactors factors = FactorSymmetric(fit.covariance);
  const double largest = factors.values.tail<1>()[0];
  if (!(largest > 0)) throw std::invalid_argument("WindowSpace: the windows never vary");
  const Eigen::Index kept = std::min<Eigen::Index>(directions, fit.mean.size());
  mean_ = fit.mean;
  basis_ = factors.vectors.rightCols(kept).rowwise().reverse();
  first_deviation_ = std::sqrt(largest);
  variance_kept_ = factors.values.tail(kept).sum() / factors.values.sum();
}

Eigen::MatrixXd WindowSpace::Project(const Eigen::MatrixXd& windows) const {
  if (windows.rows() != mean_.size()) {
    throw std::invalid_argument("WindowSpace: windows of " + std::to_string(mean_.size()) +
                                " values expected, not " + std::to_string(windows.rows()));
  }
  return basis_.transpose() * (windows.colwise() - mean_) / first_deviation_;
}

double WindowSpace::MeanSquaredResidual(const Eigen::MatrixXd& windows) const {
  if (windows.cols() == 0) return 0;
  const Eigen::MatrixXd projected = Project(windows);
  // The directions are orthonormal: what is left is the whole length without the projected one.
  const double whole = (windows.colwise() - mean_).squaredNorm() / (first_deviation_ * first_deviation_);
  return std::max(0.0, whole - projected.squaredNorm()) / static_cast<double>(windows.cols());
}

}  // namespace morphograph
