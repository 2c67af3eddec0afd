#include "primitives/weighted_pca.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

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

// Leading part of X = U diag(s) V^T, U (rows x kept), V (columns x kept), and all singular values.
struct LeadingSvd {
  Eigen::MatrixXd u, v;
  Eigen::VectorXd s;
};

// Householder QR of the longer side first, so that the iterations run on a square of the shorter one, and back through
// it with the kept axes alone. `count_kept` tells from the singular values how many those are.
template <typename CountKept>
LeadingSvd Decompose(const Eigen::MatrixXd& x, const CountKept& count_kept) {
  if (x.rows() < x.cols()) {
    LeadingSvd turned = Decompose(x.transpose(), count_kept);
    turned.u.swap(turned.v);
    return turned;
  }
  const Eigen::Index n = x.cols();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(x);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.info() != Eigen::Success) throw std::runtime_error("WeightedPca: the singular value decomposition failed");
  const Eigen::Index kept = count_kept(svd.singularValues());
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(x.rows(), kept);
  u.topRows(n) = svd.matrixU().leftCols(kept);
  u.applyOnTheLeft(qr.householderQ());
  return {std::move(u), svd.matrixV().leftCols(kept), svd.singularValues()};
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
  double threshold = 0, total = 0, sum = 0;
  const auto count_kept = [&](const Eigen::VectorXd& singular_values) {
    threshold = rounding * std::max(singular_values.size() > 0 ? singular_values[0] : 0.0, magnitude);
    total = singular_values.squaredNorm() / count;
    Eigen::Index kept = 0;
    while (kept < singular_values.size() && kept < options.max_components && singular_values[kept] > threshold &&
           sum < options.variance_kept * total) {
      sum += singular_values[kept] * singular_values[kept] / count;
      ++kept;
    }
    return kept;
  };
  const Eigen::MatrixXd weighted = root_weights.asDiagonal() * centred;
  LeadingSvd svd = Decompose(weighted, count_kept);  // Eq. 3.26, transposed: samples are columns
  const Eigen::Index kept = svd.u.cols();

  out.variances = svd.s.head(kept).array().square() / count;
  // Nothing kept is everything where there was nothing but rounding to keep.
  const double rounding_total = threshold * threshold / count * static_cast<double>(svd.s.size());
  out.variance_kept = kept > 0 ? std::min(1.0, sum / total) : (total <= rounding_total ? 1.0 : 0.0);
  out.basis.resize(samples.rows(), kept);
  for (Eigen::Index k = 0; k < kept; ++k) {
    Eigen::Index largest = 0;
    svd.u.col(k).cwiseAbs().maxCoeff(&largest);
    if (svd.u(largest, k) < 0) {
      svd.u.col(k) *= -1;
      svd.v.col(k) *= -1;
    }
  }
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    if (weights[i] > 0) {
      out.basis.row(i) = svd.u.row(i) / root_weights[i];  // B = W^(-1/2) V, Eq. 3.28
    } else {  // the same by regression, X A M^(-1), which needs no division by the weight
      out.basis.row(i) = (centred.row(i) * svd.v).array() / svd.s.head(kept).transpose().array();
    }
  }
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
