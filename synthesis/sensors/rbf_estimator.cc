#include "synthesis/sensors/rbf_estimator.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "datasets/parallel_for.h"

namespace morphograph {
namespace {

// Maps of clusters less likely than this have no say.
constexpr float kLeastClusterShare = 0.05f;

// Frames that have window - 1 more of their clip after them, by cluster.
std::vector<std::vector<Eigen::Index>> FramesByCluster(const MotionBase& base, const PoseClusters& clusters, int window) {
  std::vector<std::vector<Eigen::Index>> frames(static_cast<std::size_t>(clusters.count()));
  for (Eigen::Index f = 0; f + window <= base.frame_count(); ++f) {
    if (base.clip_of(f) == base.clip_of(f + window - 1)) frames[static_cast<std::size_t>(clusters.of_frame[static_cast<std::size_t>(f)])].push_back(f);
  }
  return frames;
}

}  // namespace

RbfModel::RbfModel(const MotionBase& base, const RbfOptions& given)
    : options(given), channels(base), reduction(channels.Vectors(base), given.reduction) {
  if (options.window < 1) throw std::invalid_argument("RbfModel: a window of " + std::to_string(options.window) + " frames; at least 1");
  const Eigen::MatrixXf coordinates = reduction.Coordinates(channels.Vectors(base), options.jobs);
  clusters = ClusterPoses(base, coordinates, options.clusters, options.jobs);
  auto frames = FramesByCluster(base, clusters, options.window);
  const Eigen::Index components = coordinates.rows();
  std::vector<std::unique_ptr<RadialBasisMap>> learned(frames.size());
  ParallelFor(options.jobs, clusters.count(), [&](int k) {
    std::vector<Eigen::Index>& members = frames[static_cast<std::size_t>(k)];
    // A cluster of clip ends alone: any frame does, it is the base's first then.
    if (members.empty()) members.push_back(0);
    const auto count = static_cast<Eigen::Index>(members.size());
    Eigen::MatrixXf readings(base.accelerations().rows(), count), courses(components * options.window, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index frame = members[static_cast<std::size_t>(i)];
      readings.col(i) = base.accelerations().col(frame);
      for (int ahead = 0; ahead < options.window; ++ahead)
        courses.col(i).segment(components * ahead, components) = coordinates.col(std::min(frame + ahead, base.frame_count() - 1));
    }
    learned[static_cast<std::size_t>(k)] = std::make_unique<RadialBasisMap>(readings, courses, options.map);
  });
  for (auto& map : learned) maps.push_back(std::move(*map));
}

RbfEstimator::RbfEstimator(std::shared_ptr<const RbfModel> model)
    : model_(std::move(model)), filter_(model_->clusters, model_->options.choice, model_->options.evidence) {
  said_.setZero(model_->reduction.components() * model_->options.window, model_->options.window);
}

BasePose RbfEstimator::Next(const Eigen::VectorXd& reading) {
  if (reading.size() != model_->clusters.means.rows()) {
    throw std::invalid_argument("RbfEstimator: a reading of " + std::to_string(reading.size()) + " values, not " +
                                std::to_string(model_->clusters.means.rows()));
  }
  const Eigen::VectorXf values = reading.cast<float>();
  const Eigen::VectorXf& probabilities = filter_.Next(values);
  const float least = std::min(kLeastClusterShare, probabilities.maxCoeff());
  const int window = model_->options.window;
  auto latest = said_.col(said_count_++ % window);
  latest.setZero();
  float shares = 0;
  for (Eigen::Index k = 0; k < probabilities.size(); ++k) {
    if (probabilities[k] < least) continue;
    latest += probabilities[k] * model_->maps[static_cast<std::size_t>(k)].Value(values);
    shares += probabilities[k];
  }
  latest /= shares;
  const int components = model_->reduction.components();
  const auto have = static_cast<int>(std::min<Eigen::Index>(said_count_, window));
  Eigen::VectorXf mean = Eigen::VectorXf::Zero(components);
  for (int ago = 0; ago < have; ++ago) mean += said_.col((said_count_ - 1 - ago) % window).segment(components * ago, components);
  return model_->channels.Pose(model_->reduction.Pose((mean / static_cast<float>(have)).cast<double>()));
}

}  // namespace morphograph
