#include "primitives/k_means.h"

#include <algorithm>
#include <boost/random/uniform_01.hpp>
#include <limits>

namespace morphograph {

KMeans FitKMeans(const Eigen::MatrixXd& samples, int clusters, int iterations, std::mt19937_64& rng) {
  const Eigen::Index n = samples.cols();
  KMeans out;
  out.of_sample.assign(static_cast<std::size_t>(n), 0);
  int count = 0;
  Eigen::MatrixXd centres(samples.rows(), clusters);
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  boost::random::uniform_01<double> uniform;
  for (; count < clusters; ++count) {
    Eigen::Index chosen = 0;
    if (count == 0) {
      chosen = std::min<Eigen::Index>(n - 1, static_cast<Eigen::Index>(uniform(rng) * static_cast<double>(n)));
    } else {
      const double total = nearest.sum();
      if (!(total > 0)) break;  // every sample is a centre already
      double left = uniform(rng) * total;
      // A sample at distance 0 is never chosen, so centres are distinct.
      Eigen::Index last_positive = 0;
      for (chosen = 0; chosen < n; ++chosen) {
        if (!(nearest[chosen] > 0)) continue;
        last_positive = chosen;
        if ((left -= nearest[chosen]) < 0) break;
      }
      if (chosen == n) chosen = last_positive;
    }
    centres.col(count) = samples.col(chosen);
    nearest = nearest.cwiseMin((samples.colwise() - samples.col(chosen)).colwise().squaredNorm().transpose());
  }

  for (int iteration = 0; iteration < iterations; ++iteration) {
    bool changed = iteration == 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      Eigen::Index best = 0;
      (centres.leftCols(count).colwise() - samples.col(i)).colwise().squaredNorm().minCoeff(&best);
      changed |= out.of_sample[i] != best;
      out.of_sample[i] = static_cast<int>(best);
    }
    if (!changed) break;
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(samples.rows(), count);
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(count);
    for (Eigen::Index i = 0; i < n; ++i) {
      sums.col(out.of_sample[i]) += samples.col(i);
      counts[out.of_sample[i]] += 1;
    }
    for (int k = 0; k < count; ++k)
      if (counts[k] > 0) centres.col(k) = sums.col(k) / counts[k];
  }
  out.centres = centres.leftCols(count);
  return out;
}

}  // namespace morphograph
