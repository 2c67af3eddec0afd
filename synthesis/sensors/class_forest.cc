#include "synthesis/sensors/class_forest.h"

#include <xgboost/c_api.h>

#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

namespace morphograph {
namespace {

constexpr int kForestBins = 64;
// Classes with less than this share of a leaf's samples are left out of it: in most leaves one sample or two, which
// take as long to add up as classes that matter.
constexpr float kLeastLeafShare = 0.02F;

void CheckXgboost(int status) {
  if (status != 0) throw std::runtime_error(std::string("XGBoost: ") + XGBGetLastError());
}

struct FreeMatrix {
  void operator()(void* handle) const { XGDMatrixFree(handle); }
};
struct FreeBooster {
  void operator()(void* handle) const { XGBoosterFree(handle); }
};
using Matrix = std::unique_ptr<void, FreeMatrix>;
using BoosterPtr = std::unique_ptr<void, FreeBooster>;

// One tree that tells `ones` from the rest, as XGBoost writes it.
nlohmann::json GrowTree(void* matrix, const std::vector<float>& ones, Eigen::Index features, int depth, std::uint64_t seed) {
  CheckXgboost(XGDMatrixSetFloatInfo(matrix, "label", ones.data(), ones.size()));
  const DMatrixHandle seen[] = {matrix};
  BoosterHandle handle = nullptr;
  CheckXgboost(XGBoosterCreate(seen, 1, &handle));
  const BoosterPtr booster(handle);
  const auto set = [&](const char* name, const std::string& value) { CheckXgboost(XGBoosterSetParam(handle, name, value.c_str())); };
  set("objective", "reg:squarederror");  // its splits are those of the Gini index, see random_forest.cc
  set("base_score", "0.5");
  set("lambda", "0");
  set("subsample", "0.632");
  const double tried = std::ceil(std::sqrt(static_cast<double>(features)));
  set("colsample_bynode", std::to_string(std::min(1.0, (tried + 0.01) / static_cast<double>(features))));
  set("tree_method", "hist");
  set("max_bin", std::to_string(kForestBins));
  set("max_depth", std::to_string(depth));
  set("min_child_weight", "5");
  set("seed", std::to_string(seed));
  set("nthread", "1");
  set("verbosity", "0");
  CheckXgboost(XGBoosterUpdateOneIter(handle, 0, matrix));
  bst_ulong length = 0;
  const char* text = nullptr;
  CheckXgboost(XGBoosterSaveModelToBuffer(handle, R"({"format": "json"})", &length, &text));
  return nlohmann::json::parse(text, text + length).at("learner").at("gradient_booster").at("model").at("trees").at(0);
}

}  // namespace

ClassForest::ClassForest(const Eigen::MatrixXf& samples, const std::vector<int>& labels, int classes, const ClassForestOptions& options) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("ClassForest: " + what); };
  const Eigen::Index count = samples.cols(), features = samples.rows();
  if (static_cast<Eigen::Index>(labels.size()) != count || count < 1 || features < 1)
    fail(std::to_string(labels.size()) + " labels for " + std::to_string(count) + " samples of " + std::to_string(features) + " features");
  if (!samples.allFinite()) fail("samples hold values that are not finite");
  for (const int label : labels)
    if (label < 0 || label >= classes) fail("label " + std::to_string(label) + " of " + std::to_string(classes) + " classes");
  if (options.trees < 1 || options.depth < 1 || options.most_samples < 1) fail("needs a tree, a level and a sample at least");

  const Eigen::Index taken = std::min<Eigen::Index>(count, options.most_samples);
  Eigen::MatrixXf seen(features, taken);
  std::vector<int> seen_labels;
  for (Eigen::Index i = 0; i < taken; ++i) {
    const Eigen::Index from = i * count / taken;
    seen.col(i) = samples.col(from);
    seen_labels.push_back(labels[static_cast<std::size_t>(from)]);
  }
  DMatrixHandle handle = nullptr;
  CheckXgboost(XGDMatrixCreateFromMat(seen.data(), static_cast<bst_ulong>(taken), static_cast<bst_ulong>(features),
                                      std::numeric_limits<float>::quiet_NaN(), &handle));
  const Matrix matrix(handle);
  std::mt19937_64 rng(options.seed);
  classes_ = classes;
  trees_ = options.trees;
  nodes_.resize(static_cast<std::size_t>(trees_));
  for (int t = 0; t < options.trees; ++t) {
    // Half of the classes, another half every time.
    std::vector<float> code(static_cast<std::size_t>(classes), 0);
    std::vector<int> order(code.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(k);
    for (std::size_t k = order.size(); k > 1; --k)
      std::swap(order[k - 1], order[boost::random::uniform_int_distribution<std::size_t>(0, k - 1)(rng)]);
    for (std::size_t k = 0; k < order.size() / 2; ++k) code[static_cast<std::size_t>(order[k])] = 1;
    std::vector<float> ones;
    for (const int label : seen_labels) ones.push_back(code[static_cast<std::size_t>(label)]);
    const nlohmann::json tree = GrowTree(handle, ones, features, options.depth, rng() >> 33);
    const auto left = tree.at("left_children").get<std::vector<int>>(), right = tree.at("right_children").get<std::vector<int>>();
    const auto feature = tree.at("split_indices").get<std::vector<int>>();
    const auto threshold = tree.at("split_conditions").get<std::vector<float>>();
    // Level by level, the two below a node beside each other.
    std::vector<std::pair<std::size_t, std::size_t>> level = {{0, static_cast<std::size_t>(t)}};  // XGBoost's number, and ours
    for (int depth = 0; !level.empty(); ++depth) {
      levels_ = std::max(levels_, depth);
      std::vector<std::pair<std::size_t, std::size_t>> next;
      for (const auto& [theirs, ours] : level) {
        Node& node = nodes_[ours];
        if (left[theirs] < 0) {
          node = {std::numeric_limits<float>::infinity(), 0, static_cast<int>(ours)};
          continue;
        }
        const std::size_t below = nodes_.size();
        node = {threshold[theirs], feature[theirs], static_cast<int>(below)};
        next.emplace_back(static_cast<std::size_t>(left[theirs]), below);
        next.emplace_back(static_cast<std::size_t>(right[theirs]), below + 1);
        nodes_.resize(below + 2);
      }
      level = std::move(next);
    }
  }

  std::vector<std::vector<float>> counts(nodes_.size());
  std::vector<int> leaves(static_cast<std::size_t>(trees_));
  for (Eigen::Index i = 0; i < count; ++i) {
    FindLeaves(samples.col(i).data(), 0, trees_, leaves.data());
    for (const int leaf : leaves) {
      std::vector<float>& of_leaf = counts[static_cast<std::size_t>(leaf)];
      if (of_leaf.empty()) of_leaf.resize(static_cast<std::size_t>(classes), 0);
      of_leaf[static_cast<std::size_t>(labels[static_cast<std::size_t>(i)])] += 1;
    }
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    first_share_.push_back(static_cast<int>(shares_.size()));
    if (nodes_[n].left != static_cast<int>(n)) continue;
    std::vector<float>& of_leaf = counts[n];
    if (of_leaf.empty()) of_leaf.assign(static_cast<std::size_t>(classes), 1);  // nothing fell there
    float sum = 0;
    for (const float samples_of : of_leaf) sum += samples_of;
    const float least = kLeastLeafShare * sum;
    if (*std::max_element(of_leaf.begin(), of_leaf.end()) >= least) {  // else no class is rarer than the rest
      sum = 0;
      for (float& samples_of : of_leaf) {
        if (samples_of < least) samples_of = 0;
        sum += samples_of;
      }
    }
    for (std::size_t k = 0; k < of_leaf.size(); ++k) {
      if (of_leaf[k] > 0) shares_.push_back({static_cast<int>(k), of_leaf[k] / sum / static_cast<float>(trees_)});
    }
  }
  first_share_.push_back(static_cast<int>(shares_.size()));
}

void ClassForest::FindLeaves(const float* sample, int first_tree, int trees, int* leaves) const {
  for (int t = 0; t < trees; ++t) leaves[t] = first_tree + t;
  for (int level = 0; level < levels_; ++level) {
    for (int t = 0; t < trees; ++t) {
      const Node& node = nodes_[static_cast<std::size_t>(leaves[t])];
      leaves[t] = node.left + (sample[node.feature] >= node.threshold ? 1 : 0);
    }
  }
}

void ClassForest::Probabilities(const Eigen::VectorXf& sample, Eigen::Ref<Eigen::VectorXf> probabilities) const {
  probabilities.setZero();
  // As many at a time as fit on the stack.
  constexpr int kAtOnce = 64;
  int leaves[kAtOnce];
  struct Range {
    const Share *from, *to;
  } ranges[kAtOnce];
  for (int first = 0; first < trees_; first += kAtOnce) {
    const int trees = std::min(kAtOnce, trees_ - first);
    FindLeaves(sample.data(), first, trees, leaves);
    for (int t = 0; t < trees; ++t) {
      const int* place = &first_share_[static_cast<std::size_t>(leaves[t])];
      ranges[t] = {shares_.data() + place[0], shares_.data() + place[1]};
      __builtin_prefetch(ranges[t].from);
    }
    for (int t = 0; t < trees; ++t) {
      for (const Share* share = ranges[t].from; share != ranges[t].to; ++share) probabilities[share->of_class] += share->share;
    }
  }
}

Eigen::VectorXf ClassForest::Probabilities(const Eigen::VectorXf& sample) const {
  Eigen::VectorXf probabilities(classes_);
  Probabilities(sample, probabilities);
  return probabilities;
}

}  // namespace morphograph
