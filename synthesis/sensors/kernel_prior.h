#pragma once

#include <Eigen/Core>

namespace morphograph {

/// Prior of a vector given by weighted samples of what it may be (Tautges et al. 2011, Eqs. 5, 7, 8, 11, without the weights of the terms):
///
///   E(y) = sum_i w_i (|y_i - y|^2 + r_i)^(1/4)
///
/// which is the square root of the distances for r = 0. There its gradient has no limit at the samples, so some softening r > 0 is needed; r_i also takes up
/// the part of a sample that lies off the space in which y moves.
class KernelPrior {
 public:
  /// @param samples  (dims x count). @param weights  (count). @param softening  (count), all positive.
  /// @throws std::invalid_argument for sizes that do not fit, or a softening that is not positive.
  KernelPrior(Eigen::MatrixXd samples, const Eigen::VectorXd& weights, const Eigen::VectorXd& softening);

  /// E(y). @param gradient  if given, is raised by scale * dE/dy.
  double Energy(const Eigen::VectorXd& y, double scale, Eigen::VectorXd* gradient) const;

 private:
  Eigen::VectorXd origin_;   // the weighted mean: distances are taken from products of vectors about it
  Eigen::MatrixXd samples_;  // about the origin
  Eigen::VectorXd squared_norms_, weights_;  // of the samples, with the softening
};

/// The same from a multivariate normal distribution (Chai & Hodgins 2005, in place of the kernels as in Tautges 6.2.5): the Mahalanobis
/// distance, or half its square, which is what -log of the density says.
class GaussianPrior {
 public:
  /// @param ridge  added to the variance of every value (its square, in units of y): neighbours of one reading are nearly alike, and their covariance
  ///   alone would forbid what they happen not to do.
  /// @throws std::invalid_argument for sizes that do not fit, or a ridge that is not positive.
  GaussianPrior(const Eigen::MatrixXd& samples, const Eigen::VectorXd& weights, double ridge, bool squared);

  double Energy(const Eigen::VectorXd& y, double scale, Eigen::VectorXd* gradient) const;

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd precision_;
  bool squared_;
};

}  // namespace morphograph
