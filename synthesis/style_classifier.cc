#include "synthesis/style_classifier.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "synthesis/pose_windows.h"

namespace morphograph {
namespace {

WindowSpace SpaceOf(const std::vector<StyledWindows>& clips) {
  std::vector<Eigen::MatrixXd> parts;
  for (const StyledWindows& clip : clips) parts.push_back(clip.windows);
  return WindowSpace(JoinColumns(parts));
}

Eigen::VectorXd ClipFeatures(const WindowSpace& space, const Eigen::MatrixXd& windows) {
  if (windows.cols() < 2) throw std::invalid_argument("StyleClassifier: a clip needs two windows or more");
  const Eigen::MatrixXd projected = space.Project(windows);
  const Eigen::VectorXd mean = projected.rowwise().mean();
  Eigen::VectorXd features(2 * mean.size());
  features << mean, (projected.colwise() - mean).rowwise().squaredNorm().array().sqrt().matrix() /
                        std::sqrt(static_cast<double>(windows.cols()));
  return features;
}

double Accuracy(const Eigen::MatrixXi& counts) {
  return counts.sum() > 0 ? static_cast<double>(counts.trace()) / counts.sum() : 0.0;
}

int IndexOf(const std::vector<std::string>& styles, const std::string& style) {
  const auto at = std::find(styles.begin(), styles.end(), style);
  if (at == styles.end()) throw std::invalid_argument("ConfuseStyles: unknown style '" + style + "'");
  return static_cast<int>(at - styles.begin());
}

}  // namespace

StyleClassifier::StyleClassifier(const std::vector<StyledWindows>& captured,
                                 const StyleClassifierOptions& options)
    : space_(SpaceOf(captured)) {
  if (!(options.shrinkage >= 0 && options.shrinkage <= 1)) {
    throw std::invalid_argument("StyleClassifier: shrinkage must lie in [0, 1]");
  }
  std::map<std::string, std::vector<Eigen::VectorXd>> features;
  for (const StyledWindows& clip : captured)
    features[clip.style].push_back(ClipFeatures(space_, clip.windows));
  if (features.size() < 2) throw std::invalid_argument("StyleClassifier: at least two styles are needed");

  const Eigen::Index size = features.begin()->second.front().size();
  Eigen::MatrixXd pooled = Eigen::MatrixXd::Zero(size, size);
  centroids_.resize(size, static_cast<Eigen::Index>(features.size()));
  for (const auto& [style, of_style] : features) {
    if (of_style.size() < 2)
      throw std::invalid_argument("StyleClassifier: style '" + style + "' needs two clips or more");
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(size);
    for (const Eigen::VectorXd& one : of_style) mean += one / static_cast<double>(of_style.size());
    for (const Eigen::VectorXd& one : of_style) pooled += (one - mean) * (one - mean).transpose();
    centroids_.col(static_cast<Eigen::Index>(styles_.size())) = mean;
    styles_.push_back(style);
  }
  // The divisor only scales all distances alike. The last term keeps directions that never vary from being
  // divided by 0.
  pooled /= static_cast<double>(captured.size());
  const Eigen::VectorXd diagonal = pooled.diagonal();
  pooled *= 1 - options.shrinkage;
  pooled.diagonal() +=
      options.shrinkage * diagonal + Eigen::VectorXd::Constant(size, 1e-12 + 1e-9 * diagonal.maxCoeff());
  const Eigen::LLT<Eigen::MatrixXd> cholesky(pooled);
  if (cholesky.info() != Eigen::Success)
    throw std::runtime_error("StyleClassifier: the covariance is not definite");
  whitener_ = cholesky.matrixL();
  whitener_.triangularView<Eigen::Lower>().solveInPlace(centroids_);
}

const std::string& StyleClassifier::Classify(const Eigen::MatrixXd& windows) const {
  Eigen::VectorXd features = ClipFeatures(space_, windows);
  whitener_.triangularView<Eigen::Lower>().solveInPlace(features);
  Eigen::Index best = 0;
  (centroids_.colwise() - features).colwise().squaredNorm().minCoeff(&best);
  return styles_[static_cast<size_t>(best)];
}

StyleConfusion ConfuseStyles(const StyleClassifier& classifier, const std::vector<StyledWindows>& clips) {
  StyleConfusion confusion;
  confusion.styles = classifier.styles();
  const Eigen::Index styles = static_cast<Eigen::Index>(confusion.styles.size());
  confusion.counts = Eigen::MatrixXi::Zero(styles, styles);
  for (const StyledWindows& clip : clips) {
    ++confusion.counts(IndexOf(confusion.styles, clip.style),
                       IndexOf(confusion.styles, classifier.Classify(clip.windows)));
  }
  confusion.accuracy = Accuracy(confusion.counts);
  return confusion;
}

StyleConfusion CrossValidateStyles(const std::vector<StyledWindows>& captured, int folds,
                                   const StyleClassifierOptions& options) {
  if (folds < 2) throw std::invalid_argument("CrossValidateStyles: at least two folds are needed");
  std::map<std::string, int> dealt;
  std::vector<int> fold_of;
  for (const StyledWindows& clip : captured) fold_of.push_back(dealt[clip.style]++ % folds);
  StyleConfusion sum;
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<StyledWindows> seen, unseen;
    for (size_t i = 0; i < captured.size(); ++i) (fold_of[i] == fold ? unseen : seen).push_back(captured[i]);
    if (unseen.empty()) continue;
    const StyleConfusion part = ConfuseStyles(StyleClassifier(seen, options), unseen);
    if (sum.styles.empty()) {
      sum = part;
    } else {
      sum.counts += part.counts;
    }
  }
  sum.accuracy = Accuracy(sum.counts);
  return sum;
}

}  // namespace morphograph
