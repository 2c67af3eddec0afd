#include "synthesis/sensors/gaussian_estimator.h"

#include <ceres/tiny_solver.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "datasets/parallel_for.h"

namespace morphograph {
namespace {

constexpr float kLeastShare = 0.05f;   // less likely clusters have no say
constexpr std::size_t kErrorSamples = 1500;  // of a cluster, for its readings' errors
constexpr double kLeastActivity = 0.01;     // a body that stands still is not pinned for good
constexpr double kBlendPriorSamples = 20;   // a cluster's covariance is drawn to that within all clusters as by so many samples

}  // namespace

GaussianModel::GaussianModel(const MotionBase& base, const GaussianOptions& given)
    : options(given), frame_rate_hz(base.frame_rate_hz()), channels(base), reduction(channels.Vectors(base), given.reduction) {
  if (options.reduction.kind != ReductionKind::kPca) throw std::invalid_argument("GaussianModel: poses must be reduced by PCA");
  if (options.smoothness_weight < 0 || options.control_weight < 0 || !(options.smoothness_unit > 0) || options.max_iterations < 1 || options.control_readings < 1 || options.control_stride < 1 ||
      !(options.surprise_s >= 0) || !(options.activity_power >= 0))
    throw std::invalid_argument("GaussianModel: weights, times and powers must not be negative, the smoothness unit positive; an iteration, a reading and a frame between them are needed");
  const Eigen::MatrixXf coordinates = reduction.Coordinates(channels.Vectors(base), options.jobs);
  clusters = ClusterPoses(base, coordinates, options.clusters, options.jobs);
  const Eigen::Index components = coordinates.rows(), frames = coordinates.cols();
  std::vector<std::vector<Eigen::Index>> members(static_cast<std::size_t>(clusters.count()));
  for (Eigen::Index f = 0; f < frames; ++f) members[static_cast<std::size_t>(clusters.of_frame[static_cast<std::size_t>(f)])].push_back(f);

  Eigen::MatrixXd within = Eigen::MatrixXd::Zero(components, components);
  for (const auto& frames_of : members) {
    const Eigen::MatrixXd poses = coordinates(Eigen::all, frames_of).cast<double>();
    means.push_back(poses.rowwise().mean());
    const Eigen::MatrixXd off = poses.colwise() - means.back();
    covariances.push_back(off * off.transpose());
    within += covariances.back() / static_cast<double>(frames);
  }
  for (std::size_t k = 0; k < members.size(); ++k)
    covariances[k] = (covariances[k] + kBlendPriorSamples * within) / (static_cast<double>(members[k].size()) + kBlendPriorSamples);

  const Eigen::Index values = base.accelerations().rows(), stride = options.control_stride, reach = (options.control_readings - 1) * stride;
  std::vector<std::unique_ptr<RadialBasisMap>> learned(members.size());
  reading_errors.resize(members.size());
  ParallelFor(options.jobs, clusters.count(), [&](int k) {
    std::vector<Eigen::Index> all = members[static_cast<std::size_t>(k)], whole;
    for (const Eigen::Index f : all)
      if (f >= reach && base.clip_of(f) == base.clip_of(f - reach)) whole.push_back(f);
    if (whole.empty()) whole = all;  // a cluster of clips' beginnings alone
    Eigen::MatrixXf stacked(values * options.control_readings, static_cast<Eigen::Index>(whole.size()));
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (int n = 0; n < options.control_readings; ++n)
        stacked.col(static_cast<Eigen::Index>(i)).segment(n * values, values) = base.accelerations().col(std::max<Eigen::Index>(0, whole[i] - n * stride));
    }
    const Eigen::MatrixXf poses = coordinates(Eigen::all, whole);
    auto map = std::make_unique<RadialBasisMap>(poses, stacked, options.map);
    Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(stacked.rows(), stacked.rows());
    const std::size_t step = 1 + whole.size() / kErrorSamples;
    double count = kBlendPriorSamples;
    for (std::size_t i = 0; i < whole.size(); i += step, ++count) {
      const auto column = static_cast<Eigen::Index>(i);
      const Eigen::VectorXd error = (stacked.col(column) - map->Value(poses.col(column))).cast<double>();
      errors.noalias() += error * error.transpose();
    }
    errors /= std::max(count - kBlendPriorSamples, 1.0);
    const Eigen::VectorXd variances = errors.diagonal();
    errors *= (count - kBlendPriorSamples) / count;
    errors.diagonal() += kBlendPriorSamples / count * variances;
    errors.diagonal().array() += options.clusters.noise_m_s2 * options.clusters.noise_m_s2 + 1e-6;
    reading_errors[static_cast<std::size_t>(k)] = errors;
    learned[static_cast<std::size_t>(k)] = std::move(map);
  });
  for (auto& map : learned) readings.push_back(std::move(*map));

  changes.setZero(components);
  long long count = 0, followed = 0;
  for (Eigen::Index f = 1; f < frames; ++f) {
    if (!base.follows(f)) continue;
    reading_change_m_s2 += static_cast<double>((base.accelerations().col(f) - base.accelerations().col(f - 1)).squaredNorm());
    ++followed;
  }
  reading_change_m_s2 = std::max(std::sqrt(reading_change_m_s2 / static_cast<double>(std::max(followed, 1LL) * values)), 1e-6);
  for (Eigen::Index f = 2; f < frames; ++f) {
    if (base.clip_of(f) != base.clip_of(f - 2)) continue;
    const auto damping = static_cast<float>(options.damping);
    changes += (coordinates.col(f) - (1 + damping) * coordinates.col(f - 1) + damping * coordinates.col(f - 2)).cwiseAbs2().cast<double>();
    ++count;
  }
  changes = options.smoothness_unit * (changes / static_cast<double>(std::max(count, 1LL))).cwiseSqrt().cwiseMax(1e-9);
}

GaussianPoseCost::GaussianPoseCost(const GaussianModel& model, const Eigen::VectorXf& shares, const Eigen::VectorXf& readings, const Eigen::VectorXd& expected,
                                   double surprise, double activity)
    : model_(model), shares_(shares), readings_(readings), expected_(expected), activity_(activity) {
  // What is below the limit fades out; a share that jumped to 0 would be seen.
  shares_ = (shares_.array() - std::min(kLeastShare, 0.5f * shares_.maxCoeff())).max(0);
  shares_ /= shares_.sum();
  const Eigen::Index components = model.means[0].size();
  mean_.setZero(components);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(components, components);
  Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(readings.size(), readings.size());
  for (Eigen::Index k = 0; k < shares_.size(); ++k) {
    if (shares_[k] > 0) mean_ += static_cast<double>(shares_[k]) * model.means[static_cast<std::size_t>(k)];
  }
  for (Eigen::Index k = 0; k < shares_.size(); ++k) {
    if (shares_[k] == 0) continue;
    const auto cluster = static_cast<std::size_t>(k);
    const Eigen::VectorXd off = model.means[cluster] - mean_;
    covariance += static_cast<double>(shares_[k]) * (model.covariances[cluster] + off * off.transpose());
    errors += static_cast<double>(shares_[k]) * model.reading_errors[cluster];
  }
  covariance.diagonal().array() += 1e-9 + 1e-6 * covariance.diagonal().mean();
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  whitening_ = factor.matrixL().solve(Eigen::MatrixXd::Identity(components, components));
  control_scale_ = std::sqrt(model.options.control_weight / surprise);
  reading_whitening_ = control_scale_ * Eigen::LLT<Eigen::MatrixXd>(errors).matrixL().solve(Eigen::MatrixXd::Identity(errors.rows(), errors.cols()));
}

double GaussianPoseCost::Surprise(const Eigen::VectorXd& coordinates) const {
  Eigen::VectorXd residuals(NumResiduals());
  (*this)(coordinates.data(), residuals.data(), nullptr);
  return residuals.tail(readings_.size()).squaredNorm() / (control_scale_ * control_scale_ * static_cast<double>(readings_.size()));
}

int GaussianPoseCost::NumResiduals() const { return static_cast<int>(mean_.size() + expected_.size() + readings_.size()); }

bool GaussianPoseCost::operator()(const double* coordinates, double* residuals, double* jacobian) const {
  const Eigen::Index components = mean_.size(), smooth = expected_.size(), rows = NumResiduals(), values = readings_.size();
  const Eigen::Map<const Eigen::VectorXd> z(coordinates, components);
  Eigen::Map<Eigen::VectorXd> r(residuals, rows);
  r.head(components) = whitening_ * (z - mean_);
  const Eigen::ArrayXd smoothness = std::sqrt(model_.options.smoothness_weight) / (activity_ * model_.changes.array());
  if (smooth > 0) r.segment(components, smooth) = smoothness * (z - expected_).array();
  Eigen::VectorXf expected_reading = Eigen::VectorXf::Zero(values);
  Eigen::MatrixXf slope = Eigen::MatrixXf::Zero(values, jacobian ? components : 0), of_cluster;
  const Eigen::VectorXf input = z.cast<float>();
  for (Eigen::Index k = 0; k < shares_.size(); ++k) {
    if (shares_[k] == 0) continue;
    const RadialBasisMap& map = model_.readings[static_cast<std::size_t>(k)];
    if (jacobian) {
      expected_reading += shares_[k] * map.Value(input, &of_cluster);
      slope += shares_[k] * of_cluster;
    } else {
      expected_reading += shares_[k] * map.Value(input);
    }
  }
  r.tail(values).noalias() = reading_whitening_.triangularView<Eigen::Lower>() * (expected_reading - readings_).cast<double>();
  if (!jacobian) return true;
  Eigen::Map<Eigen::MatrixXd> j(jacobian, rows, components);
  j.topRows(components) = whitening_;
  if (smooth > 0) j.middleRows(components, smooth) = smoothness.matrix().asDiagonal();
  j.bottomRows(values).noalias() = reading_whitening_.triangularView<Eigen::Lower>() * slope.cast<double>();
  return true;
}

GaussianEstimator::GaussianEstimator(std::shared_ptr<const GaussianModel> model)
    : model_(std::move(model)), filter_(model_->clusters, model_->options.choice, model_->options.evidence) {
  recent_.resize(model_->clusters.means.rows(), (model_->options.control_readings - 1) * model_->options.control_stride + 1);
}

BasePose GaussianEstimator::Next(const Eigen::VectorXd& reading) {
  if (reading.size() != model_->clusters.means.rows()) {
    throw std::invalid_argument("GaussianEstimator: a reading of " + std::to_string(reading.size()) + " values, not " +
                                std::to_string(model_->clusters.means.rows()));
  }
  const Eigen::VectorXf values = reading.cast<float>();
  Eigen::VectorXd expected;
  if (before_.size() > 0) expected = last_ + model_->options.damping * (last_ - before_);
  const Eigen::Index frames = recent_.cols();
  const double memory = 1 / std::max(1.0, model_->options.surprise_s * model_->frame_rate_hz);
  if (count_ == 0) {
    recent_.colwise() = values;
  } else if (model_->options.surprise_s > 0) {
    const double change = static_cast<double>((values - recent_.col((count_ - 1) % frames)).squaredNorm()) / static_cast<double>(values.size());
    activity_ += (change / (model_->reading_change_m_s2 * model_->reading_change_m_s2) - activity_) * memory;
  }
  recent_.col(count_++ % frames) = values;
  Eigen::VectorXf readings(values.size() * model_->options.control_readings);
  for (int n = 0; n < model_->options.control_readings; ++n)
    readings.segment(n * values.size(), values.size()) = recent_.col((count_ - 1 + frames - n * model_->options.control_stride) % frames);
  const double surprise = std::max(surprise_, 1.0);
  const Eigen::VectorXf& shares = filter_.Next(values, std::pow(surprise, model_->options.surprise_evidence_power));
  const GaussianPoseCost cost(*model_, shares, readings, expected, std::pow(surprise, model_->options.surprise_control_power),
                              std::pow(std::max(activity_, kLeastActivity), 0.5 * model_->options.activity_power));
  Eigen::VectorXd coordinates = expected.size() > 0 ? expected : cost.mean();
  ceres::TinySolver<GaussianPoseCost> solver;
  solver.options.max_num_iterations = model_->options.max_iterations;
  solver.options.parameter_tolerance = 1e-5;
  solver.Solve(cost, &coordinates);
  if (model_->options.surprise_s > 0) surprise_ += (cost.Surprise(coordinates) - surprise_) * memory;
  before_ = last_;
  last_ = coordinates;
  return model_->channels.Pose(model_->reduction.Pose(coordinates));
}

}  // namespace morphograph
