#pragma once

#include <Eigen/Core>

namespace morphograph {

struct RadialBasisOptions {
  int centres = 160;       // at most; taken evenly from the samples
  int neighbours = 8;      // of a centre, whose mean distance is its width (density: Xie 5.3.1)
  double width = 2;        // times that distance
  double ridge = 1e-4;     // on the weights, times the samples: a map through every noisy sample would be worth nothing
  /// Added to the ridge, over the number of samples: so many samples that say nothing. Few samples are then held down more than many.
  double ridge_samples = 0;
};

/// y = offset + slope x + sum_i w_i exp(-|x - c_i|^2 / s_i^2) (Xie Eq. 5.8, 5.9; Powell 1992), fitted by ridge regression.
///
/// Differs from Xie, where every sample is a centre and the map passes through all: here samples outnumber centres, so it passes between, and
/// a linear part holds what goes far. Immutable, single precision inside.
class RadialBasisMap {
 public:
  /// @param inputs  (a x N). @param outputs  (b x N). N >= 1.
  /// @throws std::invalid_argument for sizes that differ or options out of range.
  RadialBasisMap(const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& outputs, const RadialBasisOptions& options);

  Eigen::Index inputs() const { return centres_.rows(); }
  Eigen::Index outputs() const { return weights_.rows(); }
  /// (b), of `input` (a).
  Eigen::VectorXf Value(const Eigen::VectorXf& input) const;
  /// The same, and the derivative (b x a).
  Eigen::VectorXf Value(const Eigen::VectorXf& input, Eigen::MatrixXf* derivative) const;
  /// Root mean square difference of each output over the samples, (b).
  const Eigen::VectorXf& residual() const { return residual_; }

 private:
  Eigen::ArrayXf Basis(const Eigen::VectorXf& input) const;

  Eigen::VectorXf mean_;            // of the inputs
  Eigen::MatrixXf centres_;         // (a x M), less the mean
  Eigen::ArrayXf centre_norms_;     // squared
  Eigen::ArrayXf inverse_squares_;  // 1 / s^2
  Eigen::MatrixXf weights_;         // (b x (1 + a + M)): offset, slope, of the centres
  Eigen::VectorXf residual_;
};

}  // namespace morphograph
