#include "synthesis/random_forest.h"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

constexpr int kBins = 256;

// Values that part the sorted ones into at most kBins groups of equal counts; equal values share a group.
std::vector<float> BinEdges(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  std::vector<float> edges;
  for (int b = 1; b < kBins; ++b) {
    const float edge = values[values.size() * b / kBins];
    if (edge < values.back() && (edges.empty() || edge > edges.back())) edges.push_back(edge);
  }
  return edges;
}

}  // namespace

using Bins = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic>;

// Grows one tree over bins, (samples x features): a node reads one feature of its samples at a time.
class RandomForest::TreeGrower {
 public:
  TreeGrower(const Bins& bins, const std::vector<char>& labels, int tried, std::mt19937_64& rng)
      : bins_(bins), labels_(labels), tried_(tried), rng_(rng), features_(static_cast<size_t>(bins.cols())) {
    std::iota(features_.begin(), features_.end(), 0);
  }

  std::vector<Node> Grow() {
    const int count = static_cast<int>(labels_.size());
    boost::random::uniform_int_distribution<int> any(0, count - 1);
    members_.resize(labels_.size());
    for (int& member : members_) member = any(rng_);
    nodes_.clear();
    Grow(0, count);
    return std::move(nodes_);
  }

 private:
  struct Split {
    double purity = -1;  // sum over both sides of ones^2 / size: greatest where the Gini index is least
    int feature = -1;
    int last_bin = 0;
  };
  struct Count {
    int all = 0, ones = 0;
  };

  // Depth is bounded by the sample count in theory and some 30 in practice.
  void Grow(int from, int to) {
    const size_t node = nodes_.size();
    int ones = 0;
    for (int i = from; i < to; ++i) ones += labels_[members_[i]];
    nodes_.push_back({.probability = static_cast<float>(ones) / static_cast<float>(to - from)});
    if (ones == 0 || ones == to - from) return;
    const Split best = FindSplit(from, to, ones);
    if (best.feature < 0) return;  // samples that no feature tells apart
    const std::uint8_t* column = bins_.col(best.feature).data();
    const auto middle = std::partition(members_.begin() + from, members_.begin() + to,
                                       [&](int i) { return column[i] <= best.last_bin; });
    const int at = static_cast<int>(middle - members_.begin());
    nodes_[node].feature = best.feature;
    nodes_[node].last_bin = best.last_bin;
    Grow(from, at);
    nodes_[node].right = static_cast<int>(nodes_.size());
    Grow(at, to);
  }

  Split FindSplit(int from, int to, int ones) {
    Split best;
    const int features = static_cast<int>(features_.size());
    // Features that do not vary in the node do not count as tried once a split is missing.
    for (int f = 0; f < features && (f < tried_ || best.feature < 0); ++f) {
      std::swap(features_[f], features_[boost::random::uniform_int_distribution<int>(f, features - 1)(rng_)]);
      TryFeature(features_[f], from, to, ones, &best);
    }
    return best;
  }

  void TryFeature(int feature, int from, int to, int ones, Split* best) {
    const std::uint8_t* column = bins_.col(feature).data();
    std::array<std::uint64_t, kBins / 64> filled{};  // a bit a bin: small nodes visit only what they fill
    for (int i = from; i < to; ++i) {
      const std::uint8_t bin = column[members_[i]];
      ++counts_[bin].all;
      counts_[bin].ones += labels_[members_[i]];
      filled[bin / 64] |= std::uint64_t{1} << (bin % 64);
    }
    Count left;
    int before = -1;
    for (int word = 0; word < kBins / 64; ++word) {
      for (std::uint64_t bits = filled[word]; bits != 0; bits &= bits - 1) {
        const int bin = 64 * word + std::countr_zero(bits);
        if (before >= 0) {
          const double right_ones = ones - left.ones, right_all = to - from - left.all;
          const double purity = static_cast<double>(left.ones) * left.ones / left.all + right_ones * right_ones / right_all;
          if (purity > best->purity) *best = {purity, feature, (before + bin - 1) / 2};
        }
        left.all += counts_[bin].all;
        left.ones += counts_[bin].ones;
        counts_[bin] = {};
        before = bin;
      }
    }
  }

  const Bins& bins_;
  const std::vector<char>& labels_;
  const int tried_;
  std::mt19937_64& rng_;
  std::vector<int> features_, members_;
  std::array<Count, kBins> counts_{};
  std::vector<Node> nodes_;
};

RandomForest::RandomForest(const Eigen::MatrixXf& samples, const std::vector<char>& labels, const RandomForestOptions& options,
                           std::mt19937_64& rng) {
  const int features = static_cast<int>(samples.rows());
  if (static_cast<Eigen::Index>(labels.size()) != samples.cols()) {
    throw std::invalid_argument("RandomForest: " + std::to_string(labels.size()) + " labels for " + std::to_string(samples.cols()) +
                                " samples");
  }
  const auto ones = std::count(labels.begin(), labels.end(), 1);
  if (ones == 0 || ones == samples.cols()) throw std::invalid_argument("RandomForest: both classes need samples");
  if (!samples.allFinite()) throw std::invalid_argument("RandomForest: samples hold values that are not finite");
  if (features < 1 || options.trees < 1 || options.features < 0 || options.features > features) {
    throw std::invalid_argument("RandomForest: needs at least one tree and one feature, and not more features than there are");
  }
  for (int f = 0; f < features; ++f) {
    const Eigen::VectorXf values = samples.row(f);
    edges_.push_back(BinEdges({values.begin(), values.end()}));
  }
  const int tried = options.features > 0 ? options.features
                                         : std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(features)))));
  const Bins bins = Binned(samples);
  TreeGrower grower(bins, labels, tried, rng);
  for (int t = 0; t < options.trees; ++t) trees_.push_back(grower.Grow());
}

Bins RandomForest::Binned(const Eigen::MatrixXf& samples) const {
  if (samples.rows() != static_cast<Eigen::Index>(edges_.size())) {
    throw std::invalid_argument("RandomForest: samples of " + std::to_string(edges_.size()) + " features expected, not " +
                                std::to_string(samples.rows()));
  }
  Bins bins(samples.cols(), samples.rows());
  for (Eigen::Index f = 0; f < samples.rows(); ++f) {
    const std::vector<float>& edges = edges_[static_cast<size_t>(f)];
    for (Eigen::Index i = 0; i < samples.cols(); ++i) {
      bins(i, f) = static_cast<std::uint8_t>(std::lower_bound(edges.begin(), edges.end(), samples(f, i)) - edges.begin());
    }
  }
  return bins;
}

Eigen::VectorXd RandomForest::Predict(const Eigen::MatrixXf& samples) const {
  const Bins bins = Binned(samples);
  Eigen::VectorXd probabilities = Eigen::VectorXd::Zero(bins.rows());
  for (const std::vector<Node>& tree : trees_) {
    for (Eigen::Index i = 0; i < bins.rows(); ++i) {
      size_t node = 0;
      while (tree[node].feature >= 0) {
        node = bins(i, tree[node].feature) <= tree[node].last_bin ? node + 1 : static_cast<size_t>(tree[node].right);
      }
      probabilities[i] += tree[node].probability;
    }
  }
  return probabilities / static_cast<double>(trees_.size());
}

}  // namespace morphograph
