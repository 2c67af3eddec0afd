#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "synthesis/window_space.h"

namespace morphograph {

/// Pose windows of a clip with the style that it is known, or asked, to have.
struct StyledWindows {
  std::string style;
  Eigen::MatrixXd windows;  // (220 x windows), synthesis/pose_windows.h
};

struct StyleClassifierOptions {
  double shrinkage = 0.02;  // of the pooled covariance towards its diagonal, [0, 1]
};

/// Tells a clip's style from its pose windows: linear discriminant analysis (Fisher 1936; equal priors, one
/// pooled within-style covariance), that is the nearest centroid in Mahalanobis distance.
///
/// A clip's features are mean and standard deviation of its windows along the leading directions of the
/// captured set (WindowSpace), so neither the phase of its steps nor its length matters.
class StyleClassifier {
 public:
  /// @param captured  at least two styles, each with two clips or more; every clip with two windows or more.
  /// @throws std::invalid_argument naming the style at fault; std::runtime_error when the covariance is not
  /// definite.
  explicit StyleClassifier(const std::vector<StyledWindows>& captured,
                           const StyleClassifierOptions& options = {});

  /// Style of least distance; the first by name when tied. @throws std::invalid_argument for fewer than two
  /// windows.
  const std::string& Classify(const Eigen::MatrixXd& windows) const;

  const std::vector<std::string>& styles() const { return styles_; }

 private:
  WindowSpace space_;
  std::vector<std::string> styles_;  // sorted
  Eigen::MatrixXd whitener_;         // lower Cholesky factor of the pooled covariance
  Eigen::MatrixXd centroids_;        // (features x styles), whitened
};

/// Rows: true style, columns: given style, counts; in the order of `styles`.
struct StyleConfusion {
  std::vector<std::string> styles;
  Eigen::MatrixXi counts;
  double accuracy = 0;
};

/// Classifies clips and counts. @throws std::invalid_argument for a style that the classifier does not know.
StyleConfusion ConfuseStyles(const StyleClassifier& classifier, const std::vector<StyledWindows>& clips);

/// How well styles can be told at all: the captured clips judged by classifiers that have not seen them,
/// `folds` parts dealt out in turn within each style. @throws as StyleClassifier.
StyleConfusion CrossValidateStyles(const std::vector<StyledWindows>& captured, int folds = 5,
                                   const StyleClassifierOptions& options = {});

}  // namespace morphograph
