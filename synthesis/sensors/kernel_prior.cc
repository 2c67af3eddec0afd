#include "synthesis/sensors/kernel_prior.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace morphograph {
namespace {

// The distance has no gradient at the mean; within this of it the function is rounded off.
constexpr double kFlat = 0.1;

}  // namespace

KernelPrior::KernelPrior(Eigen::MatrixXd samples, const Eigen::VectorXd& weights, const Eigen::VectorXd& softening)
    : samples_(std::move(samples)), weights_(weights) {
  if (samples_.cols() != weights.size() || softening.size() != weights.size())
    throw std::invalid_argument("KernelPrior: expected a weight and a softening a sample");
  if (!(softening.array() > 0).all()) throw std::invalid_argument("KernelPrior: the softening must be positive");
  origin_ = samples_ * (weights / weights.sum());
  samples_.colwise() -= origin_;
  squared_norms_ = samples_.colwise().squaredNorm().transpose() + softening;
}

double KernelPrior::Energy(const Eigen::VectorXd& y, double scale, Eigen::VectorXd* gradient) const {
  const Eigen::VectorXd from_origin = y - origin_;
  // |y_i - y|^2 = |y_i|^2 - 2 y_i.y + |y|^2, no less than the softening but for rounding.
  const Eigen::ArrayXd squared = ((squared_norms_ - 2 * (samples_.transpose() * from_origin)).array() + from_origin.squaredNorm()).max(1e-16);
  const Eigen::ArrayXd root = squared.sqrt(), kernel = root.sqrt();
  if (gradient) {
    // d/dy (s)^(1/4) = (y - y_i) / 2 s^(-3/4).
    const Eigen::VectorXd pull = (0.5 * scale) * weights_.array() / (root * kernel);
    gradient->noalias() += pull.sum() * from_origin;
    gradient->noalias() -= samples_ * pull;
  }
  return (weights_.array() * kernel).sum();
}

GaussianPrior::GaussianPrior(const Eigen::MatrixXd& samples, const Eigen::VectorXd& weights, double ridge, bool squared) : squared_(squared) {
  if (samples.cols() != weights.size()) throw std::invalid_argument("GaussianPrior: expected a weight a sample");
  if (!(ridge > 0)) throw std::invalid_argument("GaussianPrior: the ridge must be positive");
  const Eigen::VectorXd shares = weights / weights.sum();
  mean_ = samples * shares;
  const Eigen::MatrixXd scaled = (samples.colwise() - mean_) * shares.cwiseSqrt().asDiagonal();
  Eigen::MatrixXd covariance = scaled * scaled.transpose();
  covariance.diagonal().array() += ridge * ridge;
  precision_ = covariance.llt().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

double GaussianPrior::Energy(const Eigen::VectorXd& y, double scale, Eigen::VectorXd* gradient) const {
  const Eigen::VectorXd off = y - mean_, pull = precision_ * off;
  if (squared_) {
    if (gradient) *gradient += scale * pull;
    return 0.5 * off.dot(pull);
  }
  const double distance = std::sqrt(off.dot(pull) + kFlat * kFlat);
  if (gradient) *gradient += (scale / distance) * pull;
  return distance;
}

}  // namespace morphograph
