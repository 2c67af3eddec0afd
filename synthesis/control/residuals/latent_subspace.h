#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <utility>

namespace morphograph {

/// A latent that moves in a subspace only: x + basis d.
class LatentSubspace : public ceres::Manifold {
 public:
  /// @param basis  (D x r), orthonormal columns.
  explicit LatentSubspace(Eigen::MatrixXd basis) : basis_(std::move(basis)) {}
  int AmbientSize() const override { return static_cast<int>(basis_.rows()); }
  int TangentSize() const override { return static_cast<int>(basis_.cols()); }
  bool Plus(const double* x, const double* delta, double* sum) const override {
    Vector(sum, basis_.rows()) = ConstVector(x, basis_.rows()) + basis_ * ConstVector(delta, basis_.cols());
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    RowMajor(jacobian, basis_.rows(), basis_.cols()) = basis_;
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    Vector(delta, basis_.cols()) = basis_.transpose() * (ConstVector(y, basis_.rows()) - ConstVector(x, basis_.rows()));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    RowMajor(jacobian, basis_.cols(), basis_.rows()) = basis_.transpose();
    return true;
  }

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;
  using ConstVector = Eigen::Map<const Eigen::VectorXd>;
  using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  Eigen::MatrixXd basis_;
};

}  // namespace morphograph
