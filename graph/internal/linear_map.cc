#include "graph/internal/linear_map.h"

#include <Eigen/Cholesky>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "primitives/matrix_factors.h"

namespace morphograph::internal {
namespace {

// Outputs in the eigenvectors of X^T X: how much of each lies along which of them, squared.
struct Spectrum {
  Eigen::ArrayXd values;     // eigenvalues, those left out are 0
  Eigen::ArrayXXd energies;  // (E x values)
  Eigen::ArrayXd rest;       // (E) along all eigenvectors that are left out
};

// Of (N x N) matrices as X X^T (D x D) has it where that is the smaller one: X^T X has its eigenvalues, and X^T v its eigenvectors.
Spectrum SpectrumOf(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs) {
  if (inputs.cols() <= inputs.rows()) {
    const SymmetricFactors factors = FactorSymmetric(inputs.transpose() * inputs);
    return {factors.values.cwiseMax(0.0), (outputs * factors.vectors).array().square(), Eigen::ArrayXd::Zero(outputs.rows())};
  }
  const SymmetricFactors factors = FactorSymmetric(inputs * inputs.transpose());
  const double rounding = static_cast<double>(inputs.cols()) * std::numeric_limits<double>::epsilon() * std::max(0.0, factors.values.maxCoeff());
  const Eigen::Index none = (factors.values.array() <= rounding).count();  // they ascend
  const Eigen::Index left = factors.values.size() - none;
  Spectrum spectrum{factors.values.tail(left), {}, {}};
  const Eigen::MatrixXd projected = outputs * (inputs.transpose() * factors.vectors.rightCols(left));
  spectrum.energies = projected.array().square().rowwise() / spectrum.values.transpose();
  spectrum.rest = (outputs.rowwise().squaredNorm().array() - spectrum.energies.rowwise().sum()).max(0.0);
  return spectrum;
}

// Ridges and likelihood for scaled inputs: K = c (X^T X + r I). In the eigenvectors u_i of X^T X, with eigenvalues s_i, the likelihood
// of an output and its best c are sums over i.
LinearRidges ForScale(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const Eigen::VectorXd& scale) {
  const Eigen::MatrixXd scaled = scale.asDiagonal() * inputs;
  const Spectrum spectrum = SpectrumOf(scaled, outputs);
  const Eigen::ArrayXd& values = spectrum.values;
  const double count = static_cast<double>(inputs.cols()), left_out = count - static_cast<double>(values.size());
  const double mean_square = std::max(scaled.colwise().squaredNorm().mean(), 1e-12);
  LinearRidges ridges{scale, Eigen::VectorXd(outputs.rows()), Eigen::VectorXd(outputs.rows()), 0};
  for (Eigen::Index e = 0; e < outputs.rows(); ++e) {
    const Eigen::ArrayXd energy = spectrum.energies.row(e).transpose();
    const auto variance = [&](double ratio) { return std::max(((energy / (values + ratio)).sum() + spectrum.rest[e] / ratio) / count, 1e-12); };
    const auto cost = [&](double log_ratio) {
      const double ratio = std::exp(log_ratio);
      return std::log(variance(ratio)) + ((values + ratio).log().sum() + left_out * log_ratio) / count;
    };
    const auto [log_ratio, least] =
        boost::math::tools::brent_find_minima(cost, std::log(1e-3 * mean_square), std::log(1e4 * mean_square), 20);
    ridges.ridge[e] = std::exp(log_ratio);
    ridges.noise_variance[e] = variance(ridges.ridge[e]) * ridges.ridge[e];
    ridges.log_likelihood -= 0.5 * count * (least + 1 + std::log(2 * M_PI));
  }
  return ridges;
}

}  // namespace

LinearRidges SearchLinearRidges(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const Eigen::VectorXd& scales) {
  if (scales.size() == 0) return ForScale(inputs, outputs, Eigen::VectorXd::Ones(inputs.rows()));
  LinearRidges best;
  best.log_likelihood = -std::numeric_limits<double>::infinity();
  for (const double power : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    LinearRidges ridges = ForScale(inputs, outputs, scales.array().pow(power));
    if (ridges.log_likelihood > best.log_likelihood) best = std::move(ridges);
  }
  return best;
}

LinearMap FitLinearMap(const LinearRidges& ridges, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                    const std::vector<int>& groups) {
  const Eigen::MatrixXd scaled = ridges.scale.asDiagonal() * inputs;
  const SymmetricFactors factors = FactorSymmetric(scaled * scaled.transpose());
  const Eigen::ArrayXd values = factors.values.cwiseMax(0.0);
  const Eigen::MatrixXd turned = factors.vectors.transpose() * scaled;  // (D x N)
  std::map<int, std::vector<Eigen::Index>> members;
  for (Eigen::Index i = 0; i < inputs.cols(); ++i) {
    members[groups.empty() ? static_cast<int>(i) : groups[static_cast<size_t>(i)]].push_back(i);
  }
  LinearMap fit{Eigen::MatrixXd(outputs.rows(), inputs.rows()), Eigen::MatrixXd(outputs.rows(), inputs.cols())};
  for (Eigen::Index e = 0; e < outputs.rows(); ++e) {
    const Eigen::VectorXd gains = (values + ridges.ridge[e]).inverse();
    const Eigen::VectorXd coefficients = gains.cwiseProduct(turned * outputs.row(e).transpose());
    fit.map.row(e) = (factors.vectors * coefficients).cwiseProduct(ridges.scale).transpose();
    const Eigen::VectorXd missed = outputs.row(e).transpose() - turned.transpose() * coefficients;
    for (const auto& [group, of_group] : members) {
      const Eigen::MatrixXd part = turned(Eigen::all, of_group);
      Eigen::MatrixXd blind = -part.transpose() * gains.asDiagonal() * part;  // I - H: what the group's own pairs hide
      blind.diagonal().array() += 1;
      const Eigen::VectorXd unseen = blind.llt().solve(missed(of_group));
      for (size_t i = 0; i < of_group.size(); ++i) fit.residuals(e, of_group[i]) = unseen[static_cast<Eigen::Index>(i)];
    }
  }
  return fit;
}

}  // namespace morphograph::internal
