#include "synthesis/sensors/radial_basis_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace morphograph {

RadialBasisMap::RadialBasisMap(const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& outputs, const RadialBasisOptions& options) {
  const Eigen::Index samples = inputs.cols();
  if (samples < 1 || outputs.cols() != samples || inputs.rows() < 1) throw std::invalid_argument("RadialBasisMap: inputs and outputs of as many samples, one or more, are needed");
  if (options.centres < 1 || options.neighbours < 1 || !(options.width > 0) || !(options.ridge > 0) || !(options.ridge_samples >= 0))
    throw std::invalid_argument("RadialBasisMap: centres, neighbours, width and ridge must be positive, ridge_samples 0 or more");
  mean_ = inputs.rowwise().mean();
  const Eigen::MatrixXf centred = inputs.colwise() - mean_;
  // No more centres than a quarter of the samples, or the residual would say nothing of other samples.
  const Eigen::Index count = std::clamp<Eigen::Index>(samples / 4, 1, options.centres);
  centres_.resize(inputs.rows(), count);
  for (Eigen::Index i = 0; i < count; ++i) centres_.col(i) = centred.col((2 * i + 1) * samples / (2 * count));
  centre_norms_ = centres_.colwise().squaredNorm().transpose().array();
  inverse_squares_.resize(count);
  const float spread = std::max(std::sqrt(centred.squaredNorm() / static_cast<float>(samples)), 1e-6f);
  const auto near = static_cast<std::size_t>(std::min<Eigen::Index>(options.neighbours, count - 1));
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::VectorXf apart = (centres_.colwise() - centres_.col(i)).colwise().norm();
    std::vector<float> distances(apart.begin(), apart.end());
    std::partial_sort(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(near) + 1, distances.end());
    float sum = 0;
    for (std::size_t n = 1; n <= near; ++n) sum += distances[n];
    // Centres that lie on each other, or a single one, reach as far as the samples do.
    const float width = sum > 0 ? static_cast<float>(options.width) * sum / static_cast<float>(near) : spread;
    inverse_squares_[i] = 1 / (width * width);
  }

  const Eigen::Index rows = 1 + inputs.rows() + count;
  Eigen::MatrixXf basis(rows, samples);
  for (Eigen::Index s = 0; s < samples; ++s) basis.col(s) << 1, centred.col(s), Basis(centred.col(s)).matrix();
  Eigen::MatrixXd gram = (basis * basis.transpose()).cast<double>();
  const auto n = static_cast<double>(samples);
  const double ridge = options.ridge + options.ridge_samples / n;
  gram.diagonal()[0] += 1e-9 * n;
  gram.diagonal().segment(1, inputs.rows()).array() += ridge * n * static_cast<double>(spread) * static_cast<double>(spread) / static_cast<double>(inputs.rows());
  gram.diagonal().tail(count).array() += ridge * n;
  const Eigen::LLT<Eigen::MatrixXd> factor(gram);
  if (factor.info() != Eigen::Success) throw std::invalid_argument("RadialBasisMap: samples are not finite");
  weights_ = factor.solve((basis * outputs.transpose()).cast<double>()).transpose().cast<float>();
  residual_ = ((outputs - weights_ * basis).rowwise().squaredNorm() / static_cast<float>(samples)).cwiseSqrt();
}

Eigen::ArrayXf RadialBasisMap::Basis(const Eigen::VectorXf& input) const {
  const Eigen::ArrayXf distances = (centre_norms_ + input.squaredNorm() - 2 * (centres_.transpose() * input).array()).max(0);
  return (-distances * inverse_squares_).exp();
}

Eigen::VectorXf RadialBasisMap::Value(const Eigen::VectorXf& input) const {
  const Eigen::VectorXf x = input - mean_;
  Eigen::VectorXf value = weights_.col(0);
  value.noalias() += weights_.middleCols(1, x.size()) * x;
  value.noalias() += weights_.rightCols(centres_.cols()) * Basis(x).matrix();
  return value;
}

Eigen::VectorXf RadialBasisMap::Value(const Eigen::VectorXf& input, Eigen::MatrixXf* derivative) const {
  const Eigen::VectorXf x = input - mean_;
  const Eigen::ArrayXf basis = Basis(x);
  Eigen::VectorXf value = weights_.col(0);
  value.noalias() += weights_.middleCols(1, x.size()) * x;
  value.noalias() += weights_.rightCols(centres_.cols()) * basis.matrix();
  // d exp(-|x - c|^2 / s^2) / dx = -2 / s^2 exp(...) (x - c)
  const Eigen::VectorXf pull = -2 * inverse_squares_ * basis;
  const Eigen::MatrixXf pulled = weights_.rightCols(centres_.cols()) * pull.asDiagonal();
  *derivative = weights_.middleCols(1, x.size());
  derivative->noalias() += pulled.rowwise().sum() * x.transpose();
  derivative->noalias() -= pulled * centres_.transpose();
  return value;
}

}  // namespace morphograph
