#include "synthesis/sensors/marker_selection.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

#include "primitives/k_means.h"
#include "primitives/matrix_factors.h"

namespace morphograph {
namespace {

constexpr int kPickIterations = 50;

struct Importance {
  int clusters = 0;    // that the marker's coordinates lie in
  double distance = 0;  // of them from the clusters' means, squared, summed
};

std::vector<Importance> ImportanceOf(const Eigen::MatrixXd& loadings, const KMeans& clusters) {
  std::vector<Importance> importance;
  for (Eigen::Index m = 0; m < loadings.cols() / 3; ++m) {
    std::set<int> in;
    Importance of_marker;
    for (Eigen::Index i = 3 * m; i < 3 * m + 3; ++i) {
      const int k = clusters.of_sample[static_cast<std::size_t>(i)];
      in.insert(k);
      of_marker.distance += (loadings.col(i) - clusters.centres.col(k)).squaredNorm();
    }
    of_marker.clusters = static_cast<int>(in.size());
    importance.push_back(of_marker);
  }
  return importance;
}

// The `count` markers that are left when the least important went, those first without which every cluster stays covered.
std::vector<int> Cover(const Eigen::MatrixXd& loadings, const KMeans& clusters, int count) {
  const std::vector<Importance> importance = ImportanceOf(loadings, clusters);
  std::vector<int> order(importance.size());
  for (std::size_t m = 0; m < order.size(); ++m) order[m] = static_cast<int>(m);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const Importance &x = importance[static_cast<std::size_t>(a)], &y = importance[static_cast<std::size_t>(b)];
    return x.clusters != y.clusters ? x.clusters < y.clusters : x.distance > y.distance;
  });
  std::vector<int> covers(static_cast<std::size_t>(clusters.centres.cols()), 0);
  for (const int k : clusters.of_sample) ++covers[static_cast<std::size_t>(k)];
  std::vector<int> kept = order;
  const auto remove_where = [&](bool even_the_last) {
    for (auto at = kept.begin(); at != kept.end() && static_cast<int>(kept.size()) > count;) {
      std::vector<int> after = covers;
      bool bare = false;
      for (int i = 0; i < 3; ++i) bare |= --after[static_cast<std::size_t>(clusters.of_sample[static_cast<std::size_t>(3 * *at + i)])] == 0;
      if (bare && !even_the_last) {
        ++at;
      } else {
        covers = after;
        at = kept.erase(at);
      }
    }
  };
  remove_where(false);
  remove_where(true);
  std::sort(kept.begin(), kept.end());
  return kept;
}

// Sum of the variances that a linear map from these markers leaves of all.
double Unexplained(const Eigen::MatrixXd& covariance, const std::vector<int>& markers) {
  std::vector<Eigen::Index> rows;
  for (const int m : markers) rows.insert(rows.end(), {3 * m, 3 * m + 1, 3 * m + 2});
  Eigen::MatrixXd own = covariance(rows, rows);
  own.diagonal().array() += 1e-9 + 1e-6 * own.diagonal().mean();
  const Eigen::MatrixXd cross = covariance(rows, Eigen::all);
  return covariance.trace() - cross.cwiseProduct(own.llt().solve(cross)).sum();
}

}  // namespace

std::vector<int> PrincipalMarkers(const Eigen::MatrixXf& tracks, const MarkerSelectionOptions& options) {
  const Eigen::Index markers = tracks.rows() / 3;
  if (options.count < 1 || options.count > markers)
    throw std::invalid_argument("PrincipalMarkers: " + std::to_string(options.count) + " of " + std::to_string(markers) + " markers");
  const Eigen::MatrixXf centred = tracks.colwise() - tracks.rowwise().mean();
  const Eigen::MatrixXd covariance = (centred * centred.transpose()).cast<double>() / static_cast<double>(tracks.cols());
  const SymmetricFactors factors = FactorSymmetric(covariance);
  const Eigen::VectorXd values = factors.values.reverse().cwiseMax(0);
  Eigen::Index components = 1;
  for (double sum = values[0]; components < values.size() && sum < options.variance_kept * values.sum(); ++components) sum += values[components];
  // Coordinates as columns, (components x 3 markers).
  const Eigen::MatrixXd loadings = factors.vectors.rowwise().reverse().leftCols(components).cwiseAbs().transpose();

  std::mt19937_64 rng(options.seed);
  std::vector<int> best;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start < options.restarts; ++start) {
    // "Slightly greater" than the number of components, and no more than there are coordinates.
    const auto clusters = static_cast<int>(std::min(components + 1, loadings.cols()));
    const std::vector<int> kept = Cover(loadings, FitKMeans(loadings, clusters, kPickIterations, rng), options.count);
    const double left = Unexplained(covariance, kept);
    if (left < least) {
      least = left;
      best = kept;
    }
  }
  return best;
}

}  // namespace morphograph
