#include "synthesis/sensors/motion_segmentation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "primitives/k_means.h"
#include "primitives/matrix_factors.h"

namespace morphograph {
namespace {

constexpr int kSplitIterations = 50;

// Mean squared Mahalanobis distance of `next`, per dimension, from the Gaussian of sums over `count` frames.
double Surprise(const Eigen::VectorXd& sum, const Eigen::MatrixXd& products, double count, double variance_kept, const Eigen::MatrixXd& next) {
  const Eigen::Index dimensions = sum.size();
  const Eigen::VectorXd mean = sum / count;
  const SymmetricFactors factors = FactorSymmetric(products / count - mean * mean.transpose());
  Eigen::VectorXd variances = factors.values.cwiseMax(0);
  const double all = variances.sum();
  double kept = 0;
  Eigen::Index across = dimensions;  // axes that are left out: the first ones
  while (across > 1 && kept < variance_kept * all) kept += variances[--across];
  if (across > 0) variances.head(across).setConstant(variances.head(across).mean());
  variances.array() += 1e-9 + 1e-6 * all;
  const Eigen::MatrixXd along = factors.vectors.transpose() * (next.colwise() - mean);
  return (variances.cwiseInverse().asDiagonal() * along.cwiseAbs2()).sum() / static_cast<double>(dimensions * next.cols());
}

Eigen::VectorXd FeatureOf(const Eigen::MatrixXd& poses, Eigen::VectorXd* mean) {
  *mean = poses.rowwise().mean();
  const Eigen::MatrixXd off = poses.colwise() - *mean;
  const Eigen::MatrixXd covariance = off * off.transpose() / static_cast<double>(poses.cols());
  const Eigen::Index n = covariance.rows();
  Eigen::VectorXd entries(n * (n + 1) / 2);
  Eigen::Index at = 0;
  // Entries off the diagonal stand twice in the matrix: so distances are those of matrices.
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) entries[at++] = (i == j ? 1 : std::sqrt(2.0)) * covariance(i, j);
  return entries;
}

double Spread(const Eigen::MatrixXd& columns) {
  return std::sqrt((columns.colwise() - columns.rowwise().mean()).squaredNorm() / static_cast<double>(columns.cols()));
}

Eigen::MatrixXd InLeadingComponents(const Eigen::MatrixXd& features, double variance_kept) {
  const Eigen::MatrixXd centred = features.colwise() - features.rowwise().mean();
  const SingularFactors factors = FactorSingular(centred, [&](const Eigen::VectorXd& values) {
    Eigen::Index kept = 0;
    for (double sum = 0; kept < values.size() && sum < variance_kept * values.squaredNorm(); ++kept) sum += values[kept] * values[kept];
    return std::max<Eigen::Index>(kept, 1);
  });
  return factors.u.transpose() * centred;
}

double Farthest(const Eigen::MatrixXd& features, const std::vector<int>& members) {
  const Eigen::MatrixXd own = features(Eigen::all, members);
  return std::sqrt((own.colwise() - own.rowwise().mean()).colwise().squaredNorm().maxCoeff());
}

}  // namespace

std::vector<Eigen::Index> CutMotion(const Eigen::MatrixXd& poses, double frame_rate_hz, const SegmentationOptions& options) {
  const auto window = static_cast<Eigen::Index>(std::lround(options.first_s * frame_rate_hz));
  const auto step = std::max<Eigen::Index>(1, std::lround(options.step_s * frame_rate_hz));
  std::vector<Eigen::Index> firsts = {0};
  for (Eigen::Index first = 0; window > 1;) {
    Eigen::VectorXd sum = poses.middleCols(first, std::min(window, poses.cols() - first)).rowwise().sum();
    Eigen::MatrixXd products = poses.middleCols(first, std::min(window, poses.cols() - first)) * poses.middleCols(first, std::min(window, poses.cols() - first)).transpose();
    double valley = std::numeric_limits<double>::infinity(), peak = 0;
    Eigen::Index at_peak = -1;
    for (Eigen::Index end = first + window; end + window <= poses.cols(); end += step) {
      const double surprise = Surprise(sum, products, static_cast<double>(end - first), options.variance_kept, poses.middleCols(end, window));
      const bool past_peak = at_peak >= 0 && surprise < peak;
      if (past_peak) break;
      if (surprise < valley) valley = surprise;
      if (surprise > valley + options.rise) peak = surprise, at_peak = end;
      const auto added = poses.middleCols(end, std::min(step, poses.cols() - end));
      sum += added.rowwise().sum();
      products += added * added.transpose();
    }
    if (at_peak < 0) break;
    firsts.push_back(first = at_peak);
  }
  return firsts;
}

std::vector<int> ClusterSegments(const std::vector<Eigen::MatrixXd>& segments, const SegmentClusterOptions& options) {
  if (segments.empty()) return {};
  const auto count = static_cast<Eigen::Index>(segments.size()), dimensions = segments[0].rows();
  Eigen::MatrixXd means(dimensions, count), covariances(dimensions * (dimensions + 1) / 2, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd mean;
    covariances.col(i) = FeatureOf(segments[static_cast<std::size_t>(i)], &mean);
    means.col(i) = mean;
  }
  Eigen::MatrixXd features(means.rows() + covariances.rows(), count);
  features << options.covariance_weight / std::max(Spread(covariances), 1e-12) * covariances,
      (1 - options.covariance_weight) / std::max(Spread(means), 1e-12) * means;
  features = InLeadingComponents(features, options.variance_kept);
  const double tolerance = options.tolerance * Spread(features);

  std::mt19937_64 rng(options.seed);
  std::vector<std::vector<int>> clusters(1), leaves;
  clusters[0].resize(segments.size());
  std::iota(clusters[0].begin(), clusters[0].end(), 0);
  while (!clusters.empty()) {
    std::size_t widest = 0;
    double width = -1;
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      const double of_cluster = Farthest(features, clusters[c]);
      if (of_cluster > width) width = of_cluster, widest = c;
    }
    const std::vector<int> members = clusters[widest];
    clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(widest));
    std::vector<std::vector<int>> parts(2);
    if (width > tolerance && static_cast<int>(clusters.size() + leaves.size()) + 2 <= options.most_clusters) {
      const KMeans halves = FitKMeans(features(Eigen::all, members), 2, kSplitIterations, rng);
      for (std::size_t i = 0; i < members.size(); ++i) parts[static_cast<std::size_t>(halves.of_sample[i])].push_back(members[i]);
    }
    const bool splits = std::all_of(parts.begin(), parts.end(), [&](const std::vector<int>& part) {
      Eigen::Index frames = 0;
      for (const int i : part) frames += segments[static_cast<std::size_t>(i)].cols();
      return !part.empty() && frames >= options.least_frames;
    });
    if (splits) clusters.insert(clusters.end(), parts.begin(), parts.end());
    else leaves.push_back(members);
  }
  // Numbered by their first segment.
  std::sort(leaves.begin(), leaves.end());
  std::vector<int> cluster_of(segments.size());
  for (std::size_t c = 0; c < leaves.size(); ++c)
    for (const int i : leaves[c]) cluster_of[static_cast<std::size_t>(i)] = static_cast<int>(c);
  return cluster_of;
}

}  // namespace morphograph
