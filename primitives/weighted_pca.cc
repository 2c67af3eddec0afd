#include "primitives/weighted_pca.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "primitives/matrix_factors.h"

namespace morphograph {
namespace {

void Check(const Eigen::MatrixXd& samples, const Eigen::VectorXd& weights, const WeightedPcaOptions& options) {
  std::ostringstream problem;
  if (samples.cols() < 1) {
    problem << "no samples given";
  } else if (weights.size() != samples.rows()) {
    problem << weights.size() << " weights for " << samples.rows() << " dimensions";
  } else if (!samples.allFinite()) {
    problem << "samples hold values that are not finite";
  } else if (!(options.variance_kept > 0 && options.variance_kept <= 1)) {
    problem << "variance_kept is " << options.variance_kept << "; must be in (0, 1]";
  } else if (options.max_components < 0) {
    problem << "max_components is " << options.max_components << "; must be >= 0";
  } else {
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      if (weights[i] >= 0 && std::isfinite(weights[i])) continue;
      problem << "weight " << i << " is " << weights[i] << "; must be >= 0";
      break;
    }
  }
  if (const std::string text = problem.str(); !text.empty()) throw std::invalid_argument("WeightedPca: " + text);
}

void CheckSize(Eigen::Index actual, Eigen::Index expected, const char* what) {
  if (actual != expected)
    throw std::invalid_argument(std::string("WeightedPca: ") + what + " has " + std::to_string(actual) +
                                " entries; expected " + std::to_string(expected));
}

}  // namespace

WeightedPca FitWeightedPca(const Eigen::MatrixXd& samples, const Eigen::VectorXd& weights, const WeightedPcaOptions& options) {
  Check(samples, weights, options);
  const double count = static_cast<double>(samples.cols());
  WeightedPca out;
  out.weights = weights;
  out.mean = samples.rowwise().mean();
  const Eigen::MatrixXd centred = samples.colwise() - out.mean;
  const Eigen::VectorXd root_weights = weights.cwiseSqrt();
  // What rounding of the data leaves behind is no variance: neither relative to the largest singular value nor to the
  // size of the samples before the mean was taken out.
  const double rounding = static_cast<double>(std::max(samples.rows(), samples.cols())) * std::numeric_limits<double>::epsilon();
  const double magnitude = (root_weights.asDiagonal() * samples).norm();
  const Eigen::MatrixXd weighted = root_weights.asDiagonal() * centred;
  double threshold = 0, total = 0, sum = 0;
  const SingularFactors svd = FactorSingular(weighted, [&](const Eigen::VectorXd& values) {  // Eq. 3.26, transposed
    threshold = rounding * std::max(values.size() > 0 ? values[0] : 0.0, magnitude);
    total = values.squaredNorm() / count;
    Eigen::Index wanted = 0;
    while (wanted < values.size() && wanted < options.max_components && values[wanted] > threshold &&
           sum < options.variance_kept * total) {
      sum += values[wanted] * values[wanted] / count;
      ++wanted;
    }
    return wanted;
  });
  const Eigen::Index kept = svd.u.cols();

  out.variances = svd.values.head(kept).array().square() / count;
  // Nothing kept is everything where there was nothing but rounding to keep.
  const double rounding_total = threshold * threshold / count * static_cast<double>(svd.values.size());
  out.variance_kept = kept > 0 ? std::min(1.0, sum / total) : (total <= rounding_total ? 1.0 : 0.0);
  out.basis.resize(samples.rows(), kept);
  Eigen::VectorXd signs(kept);
  for (Eigen::Index k = 0; k < kept; ++k) {
    Eigen::Index largest = 0;
    svd.u.col(k).cwiseAbs().maxCoeff(&largest);
    signs[k] = svd.u(largest, k) < 0 ? -1 : 1;
  }
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    if (weights[i] > 0) {
      out.basis.row(i) = svd.u.row(i) / root_weights[i];  // B = W^(-1/2) V, Eq. 3.28
    } else {  // the same by regression, X A M^(-1), which needs no division by the weight
      out.basis.row(i) = (centred.row(i) * svd.v).array() / svd.values.head(kept).transpose().array();
    }
  }
  out.basis *= signs.asDiagonal();
  return out;
}

Eigen::VectorXd WeightedPca::Project(const Eigen::VectorXd& sample) const {
  CheckSize(sample.size(), mean.size(), "a sample");
  const Eigen::VectorXd weighted = weights.cwiseProduct(sample - mean);
  return basis.transpose() * weighted;
}

Eigen::MatrixXd WeightedPca::ProjectAll(const Eigen::MatrixXd& samples) const {
  CheckSize(samples.rows(), mean.size(), "a sample");
  const Eigen::MatrixXd weighted = weights.asDiagonal() * (samples.colwise() - mean);
  return basis.transpose() * weighted;
}

Eigen::VectorXd WeightedPca::Reconstruct(const Eigen::VectorXd& latent) const {
  CheckSize(latent.size(), basis.cols(), "a latent");
  Eigen::VectorXd sample = mean;
  sample.noalias() += basis * latent;
  return sample;
}

}  // namespace morphograph
