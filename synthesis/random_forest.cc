#include "synthesis/random_forest.h"

#include <xgboost/c_api.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

constexpr int kBins = 32;
constexpr double kPartSeen = 0.632;  // by a tree: as many samples as differ in one drawn with repetition, 1 - 1/e

void Check(int status) {
  if (status != 0) throw std::runtime_error(std::string("XGBoost: ") + XGBGetLastError());
}

// Samples as XGBoost holds them, a row a sample: a column-major (features x N) matrix read the other way.
class SampleRows {
 public:
  explicit SampleRows(const Eigen::MatrixXf& samples) {
    Check(XGDMatrixCreateFromMat(samples.data(), static_cast<bst_ulong>(samples.cols()), static_cast<bst_ulong>(samples.rows()),
                                 std::numeric_limits<float>::quiet_NaN(), &handle_));
  }
  ~SampleRows() { XGDMatrixFree(handle_); }
  SampleRows(const SampleRows&) = delete;
  SampleRows& operator=(const SampleRows&) = delete;
  DMatrixHandle handle() const { return handle_; }

 private:
  DMatrixHandle handle_ = nullptr;
};

}  // namespace

class RandomForest::Booster {
 public:
  explicit Booster(const SampleRows& rows) {
    const DMatrixHandle seen[] = {rows.handle()};
    Check(XGBoosterCreate(seen, 1, &handle_));
  }
  ~Booster() { XGBoosterFree(handle_); }
  Booster(const Booster&) = delete;
  Booster& operator=(const Booster&) = delete;
  BoosterHandle handle() const { return handle_; }
  void Set(const char* name, const std::string& value) { Check(XGBoosterSetParam(handle_, name, value.c_str())); }

 private:
  BoosterHandle handle_ = nullptr;
};

RandomForest::~RandomForest() = default;
RandomForest::RandomForest(RandomForest&&) noexcept = default;
RandomForest& RandomForest::operator=(RandomForest&&) noexcept = default;

RandomForest::RandomForest(const Eigen::MatrixXf& samples, const std::vector<char>& labels, const RandomForestOptions& options,
                           std::mt19937_64& rng)
    : features_(samples.rows()) {
  if (static_cast<Eigen::Index>(labels.size()) != samples.cols()) {
    throw std::invalid_argument("RandomForest: " + std::to_string(labels.size()) + " labels for " + std::to_string(samples.cols()) +
                                " samples");
  }
  const auto ones = std::count(labels.begin(), labels.end(), 1);
  if (ones == 0 || ones == samples.cols()) throw std::invalid_argument("RandomForest: both classes need samples");
  if (!samples.allFinite()) throw std::invalid_argument("RandomForest: samples hold values that are not finite");
  if (features_ < 1 || options.trees < 1 || options.depth < 1 || options.features < 0 || options.features > features_) {
    throw std::invalid_argument("RandomForest: needs a tree, a level and a feature at least, and not more features than there are");
  }
  const double tried = options.features > 0 ? options.features : std::max(1.0, std::round(std::sqrt(static_cast<double>(features_))));

  const SampleRows rows(samples);
  const std::vector<float> classes(labels.begin(), labels.end());
  Check(XGDMatrixSetFloatInfo(rows.handle(), "label", classes.data(), classes.size()));
  booster_ = std::make_unique<Booster>(rows);
  // Squared errors without shrinkage or penalty: a leaf holds the mean of its labels, a split is the best by the Gini index (for labels
  // of 0 and 1 that is the variance), and one round of trees side by side is their mean.
  booster_->Set("objective", "reg:squarederror");
  booster_->Set("base_score", "0.5");
  booster_->Set("learning_rate", "1");
  booster_->Set("lambda", "0");
  booster_->Set("num_parallel_tree", std::to_string(options.trees));
  booster_->Set("subsample", std::to_string(kPartSeen));
  // It takes the whole part of a product, which must not fall short of a whole number by rounding.
  booster_->Set("colsample_bynode", std::to_string(std::min(1.0, (tried + 0.01) / static_cast<double>(features_))));
  booster_->Set("tree_method", "hist");
  booster_->Set("max_bin", std::to_string(kBins));
  booster_->Set("max_depth", std::to_string(options.depth));
  booster_->Set("seed", std::to_string(rng() >> 33));
  booster_->Set("nthread", "1");
  booster_->Set("verbosity", "0");
  Check(XGBoosterUpdateOneIter(booster_->handle(), 0, rows.handle()));
}

Eigen::VectorXd RandomForest::Predict(const Eigen::MatrixXf& samples) const {
  if (samples.rows() != features_) {
    throw std::invalid_argument("RandomForest: samples of " + std::to_string(features_) + " features expected, not " +
                                std::to_string(samples.rows()));
  }
  if (samples.cols() == 0) return {};
  const SampleRows rows(samples);
  static constexpr char kPlainValues[] =
      R"({"type": 0, "training": false, "iteration_begin": 0, "iteration_end": 0, "strict_shape": false})";
  const bst_ulong* shape = nullptr;
  bst_ulong dimensions = 0;
  const float* values = nullptr;
  Check(XGBoosterPredictFromDMatrix(booster_->handle(), rows.handle(), kPlainValues, &shape, &dimensions, &values));
  return Eigen::Map<const Eigen::VectorXf>(values, samples.cols()).cast<double>().cwiseMax(0).cwiseMin(1);  // rounding of their mean
}

}  // namespace morphograph
