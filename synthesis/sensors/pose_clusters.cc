#include "synthesis/sensors/pose_clusters.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "datasets/parallel_for.h"
#include "primitives/gaussian_mixture.h"

namespace morphograph {
namespace {

constexpr int kPatience = 2;
// A cluster's covariance of readings is drawn to that of all clusters as by so many samples of it.
constexpr float kPriorSamples = 20;
// A body may always be somewhere else than all said so far: this share is spread evenly at every frame.
constexpr float kLost = 1e-3f;

int NextCount(int clusters) {  // 1, 2, 3, 4, 6, 8, 12, 16, …
  if (clusters < 3) return clusters + 1;
  return (clusters & (clusters - 1)) == 0 ? clusters / 2 * 3 : clusters / 3 * 4;
}

GaussianMixture FitByDescriptionLength(const Eigen::MatrixXd& samples, const PoseClusterOptions& options, std::vector<PoseClusters::Candidate>* tried) {
  GaussianMixtureOptions fit;
  fit.restarts = 1;
  fit.max_iterations = 40;
  fit.tolerance = 1e-3;
  fit.relative_floor = 1e-4;
  std::mt19937_64 rng(options.seed);
  GaussianMixture best;
  double least = std::numeric_limits<double>::infinity();
  int worse = 0;
  const double per_parameter = 0.5 * std::log(static_cast<double>(samples.size()));
  for (int k = 1; k <= options.max_clusters && worse < kPatience && k <= samples.cols(); k = NextCount(k)) {
    const GaussianMixtureFit candidate = FitGaussianMixture(samples, k, CovarianceForm::kFull, fit, rng);
    const double length = -candidate.log_likelihood + per_parameter * candidate.parameters;
    tried->push_back({k, length});
    worse = length < least ? 0 : worse + 1;
    if (length < least) {
      least = length;
      best = candidate.mixture;
    }
  }
  return best;
}

}  // namespace

PoseClusters ClusterPoses(const MotionBase& base, const Eigen::MatrixXf& all_coordinates, const PoseClusterOptions& options, int jobs) {
  const Eigen::MatrixXf& readings = base.accelerations();
  const Eigen::Index frames = base.frame_count();
  if (readings.rows() == 0) throw std::invalid_argument("ClusterPoses: the base has no sensors");
  if (all_coordinates.cols() != frames) throw std::invalid_argument("ClusterPoses: coordinates of another number of frames");
  if (options.max_clusters < 1 || options.fit_frames < 2) throw std::invalid_argument("ClusterPoses: needs a cluster and two frames at least");
  if (options.components < 1) throw std::invalid_argument("ClusterPoses: a component at least");
  const Eigen::MatrixXf coordinates = all_coordinates.topRows(std::min<Eigen::Index>(options.components, all_coordinates.rows()));
  PoseClusters clusters;
  const Eigen::Index taken = std::min<Eigen::Index>(frames, options.fit_frames);
  Eigen::MatrixXd samples(coordinates.rows(), taken);
  for (Eigen::Index i = 0; i < taken; ++i) samples.col(i) = coordinates.col(i * frames / taken).cast<double>();
  const GaussianMixture mixture = FitByDescriptionLength(samples, options, &clusters.candidates);
  clusters.of_frame.resize(static_cast<std::size_t>(frames));
  ParallelFor(jobs, static_cast<int>(frames),
              [&](int f) { clusters.of_frame[static_cast<std::size_t>(f)] = mixture.MostLikely(coordinates.col(f).cast<double>()); });

  // Clusters that no frame is in are dropped.
  std::vector<int> sizes(static_cast<std::size_t>(mixture.size()), 0), renamed(sizes.size(), -1);
  for (const int k : clusters.of_frame) ++sizes[static_cast<std::size_t>(k)];
  int count = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k)
    if (sizes[k] > 0) renamed[k] = count++;
  for (int& k : clusters.of_frame) k = renamed[static_cast<std::size_t>(k)];

  const Eigen::Index values = readings.rows();
  clusters.means.setZero(values, count);
  Eigen::VectorXf sums = Eigen::VectorXf::Zero(count);
  clusters.transitions.setZero(count, count);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const int k = clusters.of_frame[static_cast<std::size_t>(f)];
    clusters.means.col(k) += readings.col(f);
    sums[k] += 1;
    if (base.follows(f)) clusters.transitions(k, clusters.of_frame[static_cast<std::size_t>(f - 1)]) += 1;
  }
  clusters.means = clusters.means * sums.cwiseInverse().asDiagonal();
  for (int k = 0; k < count; ++k) {
    clusters.transitions(k, k) += 1e-3f;  // a cluster that is only a clip's last
    clusters.transitions.col(k) /= clusters.transitions.col(k).sum();
  }
  std::vector<Eigen::MatrixXf> scatters(static_cast<std::size_t>(count), Eigen::MatrixXf::Zero(values, values));
  Eigen::MatrixXf within = Eigen::MatrixXf::Zero(values, values);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const int k = clusters.of_frame[static_cast<std::size_t>(f)];
    const Eigen::VectorXf off = readings.col(f) - clusters.means.col(k);
    scatters[static_cast<std::size_t>(k)].noalias() += off * off.transpose();
  }
  for (const Eigen::MatrixXf& scatter : scatters) within += scatter;
  within /= static_cast<float>(frames);
  const auto noise = static_cast<float>(options.noise_m_s2 * options.noise_m_s2) + 1e-4f;
  clusters.log_scales.resize(count);
  for (int k = 0; k < count; ++k) {
    Eigen::MatrixXd covariance = ((scatters[static_cast<std::size_t>(k)] + kPriorSamples * within) / (sums[k] + kPriorSamples)).cast<double>();
    covariance.diagonal().array() += noise;
    const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
    if (factor.info() != Eigen::Success) throw std::invalid_argument("ClusterPoses: readings are not finite");
    const Eigen::MatrixXd inverse = factor.matrixL().solve(Eigen::MatrixXd::Identity(values, values));
    clusters.whitening.push_back(inverse.cast<float>());
    clusters.log_scales[k] = static_cast<float>(inverse.diagonal().array().log().sum());
  }
  return clusters;
}

ClusterFilter::ClusterFilter(const PoseClusters& clusters, ClusterChoice choice, double evidence)
    : clusters_(clusters), choice_(choice), evidence_(static_cast<float>(evidence)) {
  probabilities_.setConstant(clusters.count(), 1.f / static_cast<float>(clusters.count()));
}

const Eigen::VectorXf& ClusterFilter::Next(const Eigen::VectorXf& reading, double surprise) {
  const int count = clusters_.count();
  if (choice_ == ClusterChoice::kNearestMean) {
    Eigen::Index nearest = 0;
    (clusters_.means.colwise() - reading).colwise().squaredNorm().minCoeff(&nearest);
    probabilities_.setZero();
    probabilities_[nearest] = 1;
    return probabilities_;
  }
  Eigen::VectorXf logs(count);
  for (int k = 0; k < count; ++k) {
    const Eigen::VectorXf off = reading - clusters_.means.col(k);
    logs[k] = clusters_.log_scales[k] - 0.5f * (clusters_.whitening[static_cast<std::size_t>(k)] * off).squaredNorm();
  }
  const float most = logs.maxCoeff();
  const Eigen::VectorXf expected = (1 - kLost) * (clusters_.transitions * probabilities_).array() + kLost / static_cast<float>(count);
  probabilities_ = expected.array() * (evidence_ / static_cast<float>(surprise) * (logs.array() - most)).exp();
  probabilities_ /= probabilities_.sum();
  return probabilities_;
}

}  // namespace morphograph
