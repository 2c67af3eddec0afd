#include "primitives/gaussian_mixture.h"

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

double LogSumExp(const Eigen::VectorXd& values) {
  const double largest = values.maxCoeff();
  if (!std::isfinite(largest)) return largest;
  return largest + std::log((values.array() - largest).exp().sum());
}

}  // namespace

std::string_view CovarianceFormName(CovarianceForm form) {
  switch (form) {
    case CovarianceForm::kFull: return "full";
    case CovarianceForm::kTied: return "tied";
    case CovarianceForm::kDiagonal: return "diagonal";
  }
  return "";
}

GaussianMixture::GaussianMixture(std::vector<MixtureComponent> components) : components_(std::move(components)) {
  if (components_.empty()) throw std::invalid_argument("GaussianMixture: no components given");
  const Eigen::Index dimension = components_[0].mean.size();
  Eigen::VectorXd log_weights(size());
  for (int k = 0; k < size(); ++k) {
    const MixtureComponent& component = components_[k];
    const std::string name = "GaussianMixture: component " + std::to_string(k);
    if (component.mean.size() != dimension || component.cholesky.rows() != dimension || component.cholesky.cols() != dimension)
      throw std::invalid_argument(name + " has a mean of " + std::to_string(component.mean.size()) + " and a factor of " +
                                  std::to_string(component.cholesky.rows()) + " x " +
                                  std::to_string(component.cholesky.cols()) + "; expected dimension " + std::to_string(dimension));
    if (dimension > 0 && !(component.cholesky.diagonal().minCoeff() > 0))
      throw std::invalid_argument(name + ": the diagonal of its Cholesky factor must be positive");
    if (!component.mean.allFinite() || !component.cholesky.allFinite() || std::isnan(component.log_weight))
      throw std::invalid_argument(name + " holds values that are not finite");
    log_weights[k] = component.log_weight;
  }
  double total = LogSumExp(log_weights);
  // Weights that sum to 1 stay as they are, to the last bit: a stored mixture comes back the same.
  if (std::abs(total) < 1e-12) total = 0;
  if (!std::isfinite(total)) throw std::invalid_argument("GaussianMixture: the weights do not have a finite positive sum");
  for (MixtureComponent& component : components_) {
    component.log_weight -= total;
    log_scale_.push_back(component.log_weight - component.cholesky.diagonal().array().log().sum() -
                         0.5 * static_cast<double>(dimension) * std::log(2 * std::numbers::pi));
  }
}

Eigen::VectorXd GaussianMixture::LogJoint(const Eigen::VectorXd& x) const {
  if (components_.empty()) throw std::invalid_argument("GaussianMixture: has no components");
  if (x.size() != dimension())
    throw std::invalid_argument("GaussianMixture: a point has " + std::to_string(x.size()) + " entries; expected " +
                                std::to_string(dimension()));
  Eigen::VectorXd out(size());
  for (int k = 0; k < size(); ++k) {
    const Eigen::VectorXd whitened = components_[k].cholesky.triangularView<Eigen::Lower>().solve(x - components_[k].mean);
    out[k] = log_scale_[k] - 0.5 * whitened.squaredNorm();
  }
  return out;
}

double GaussianMixture::LogDensity(const Eigen::VectorXd& x) const { return LogSumExp(LogJoint(x)); }

Eigen::VectorXd GaussianMixture::LogResponsibilities(const Eigen::VectorXd& x) const {
  const Eigen::VectorXd joint = LogJoint(x);
  return joint.array() - LogSumExp(joint);
}

int GaussianMixture::MostLikely(const Eigen::VectorXd& x) const {
  Eigen::Index best = 0;
  LogJoint(x).maxCoeff(&best);
  return static_cast<int>(best);
}

Eigen::VectorXd GaussianMixture::Sample(std::mt19937_64& rng) const {
  if (components_.empty()) throw std::invalid_argument("GaussianMixture: has no components");
  double left = boost::random::uniform_01<double>()(rng);
  int chosen = 0;
  while (chosen + 1 < size() && (left -= std::exp(components_[chosen].log_weight)) >= 0) ++chosen;
  return SampleComponent(chosen, rng);
}

Eigen::VectorXd GaussianMixture::SampleComponent(int index, std::mt19937_64& rng) const {
  if (index < 0 || index >= size())
    throw std::invalid_argument("GaussianMixture: component " + std::to_string(index) + " of " + std::to_string(size()));
  boost::random::normal_distribution<double> normal;
  Eigen::VectorXd z(dimension());
  for (double& value : z) value = normal(rng);
  const MixtureComponent& component = components_[index];
  return component.mean + component.cholesky.triangularView<Eigen::Lower>() * z;
}

}  // namespace morphograph
