#include "synthesis/window_classifier.h"

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

#include "datasets/parallel_for.h"
#include "datasets/resample.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/pose_windows.h"
#include "synthesis/random_forest.h"

namespace morphograph {
namespace {

using Windows = std::vector<Eigen::MatrixXd>;  // a matrix a clip

// Independent streams from one seed (the finaliser of splitmix64, Steele et al. 2014).
std::uint64_t Mixed(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ull * (stream + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

template <typename Values>
void Shuffle(Values* values, std::mt19937_64& rng) {
  for (size_t i = values->size(); i > 1; --i) {
    std::swap((*values)[i - 1], (*values)[boost::random::uniform_int_distribution<size_t>(0, i - 1)(rng)]);
  }
}

std::vector<int> Ascending(size_t count) {
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

// The windows of a set that take part: their clip's fold, and which column of the clip.
struct Dealt {
  std::vector<const Eigen::MatrixXd*> clip;
  std::vector<Eigen::Index> column;
  std::vector<int> fold;
};

Eigen::Index CountWindows(const Windows& set) {
  Eigen::Index count = 0;
  for (const Eigen::MatrixXd& clip : set) count += clip.cols();
  return count;
}

// Long clips first, each to the fold with the fewest windows so far; then `wanted` of all windows are drawn.
Dealt Deal(const Windows& set, int folds, Eigen::Index wanted, std::mt19937_64& rng) {
  std::vector<int> order = Ascending(set.size());
  Shuffle(&order, rng);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return set[a].cols() > set[b].cols(); });
  std::vector<Eigen::Index> held(folds, 0);
  std::vector<std::pair<int, Eigen::Index>> all;  // (clip, column)
  std::vector<int> fold_of(set.size());
  for (const int c : order) {
    const auto least = std::min_element(held.begin(), held.end());
    fold_of[c] = static_cast<int>(least - held.begin());
    *least += set[c].cols();
    for (Eigen::Index w = 0; w < set[c].cols(); ++w) all.emplace_back(c, w);
  }
  Shuffle(&all, rng);
  all.resize(static_cast<size_t>(wanted));
  Dealt dealt;
  for (const auto& [c, w] : all) {
    dealt.clip.push_back(&set[c]);
    dealt.column.push_back(w);
    dealt.fold.push_back(fold_of[c]);
  }
  return dealt;
}

void CheckSet(const Windows& set, int folds) {
  const auto filled = std::count_if(set.begin(), set.end(), [](const Eigen::MatrixXd& clip) { return clip.cols() > 0; });
  if (filled < folds) {
    throw std::invalid_argument("CrossValidatedAuc: " + std::to_string(filled) + " clips with windows cannot fill " +
                                std::to_string(folds) + " folds");
  }
}

MotionClip AtEvaluationRate(const MotionClip& clip) {
  const bool at_rate = std::abs(clip.frame_rate_hz() - kEvaluationRateHz) <= 1e-3 * kEvaluationRateHz;
  return at_rate ? clip : Resample(clip, kEvaluationRateHz);
}

std::vector<MotionClip> AtEvaluationRate(const std::vector<MotionClip>& clips, int jobs) {
  std::vector<MotionClip> at_rate(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()), [&](int i) { at_rate[i] = AtEvaluationRate(clips[i]); });
  return at_rate;
}

std::uint64_t CapturedSeed(const WindowClassifierOptions& options, int clip) { return Mixed(options.seed, static_cast<std::uint64_t>(clip)); }
std::uint64_t HalvingSeed(const WindowClassifierOptions& options, int halving) {
  return Mixed(options.seed, 1000003ull + static_cast<std::uint64_t>(halving));
}

// Windows of synthesised clips in a random order, cut at random places to as many frames as each of `lengths`.
Windows CutAlike(const std::vector<MotionClip>& drawn, const std::vector<int>& lengths, double noise_m, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<int> order = Ascending(drawn.size());
  Windows windows;
  for (size_t k = 0; k < lengths.size(); ++k) {
    if (k % order.size() == 0) Shuffle(&order, rng);
    const MotionClip& clip = drawn[order[k % order.size()]];
    const int length = std::min(lengths[k], clip.frame_count());
    const int from = boost::random::uniform_int_distribution<int>(0, clip.frame_count() - length)(rng);
    windows.push_back(NoisyPoseWindows(clip.Slice(from, length), noise_m, Mixed(seed, k)));
  }
  return windows;
}

std::vector<ClipHalves> RandomHalvings(size_t clips, const WindowClassifierOptions& options) {
  std::mt19937_64 rng(options.seed);
  std::vector<ClipHalves> halvings(static_cast<size_t>(std::max(0, options.halvings)));
  for (auto& [a, b] : halvings) {
    std::vector<int> order = Ascending(clips);
    Shuffle(&order, rng);
    for (size_t i = 0; i < order.size(); ++i) (i % 2 == 0 ? a : b).push_back(order[i]);
  }
  return halvings;
}

std::vector<int> LengthsOf(const std::vector<int>& frames, const std::vector<int>& clips) {
  std::vector<int> lengths;
  for (const int i : clips) lengths.push_back(frames.at(i));
  return lengths;
}

}  // namespace

double AreaUnderCurve(const std::vector<double>& low, const std::vector<double>& high) {
  if (low.empty() || high.empty()) throw std::invalid_argument("AreaUnderCurve: both sets need values");
  std::vector<std::pair<double, int>> all;
  for (const double value : low) all.emplace_back(value, 0);
  for (const double value : high) all.emplace_back(value, 1);
  std::sort(all.begin(), all.end());
  double ranks = 0;  // of `high`, from 1
  for (size_t i = 0; i < all.size();) {
    size_t end = i;
    int ones = 0;
    for (; end < all.size() && all[end].first == all[i].first; ++end) ones += all[end].second;
    ranks += ones * (static_cast<double>(i + 1) + static_cast<double>(end)) / 2;
    i = end;
  }
  const double n = static_cast<double>(high.size());
  return (ranks - n * (n + 1) / 2) / (n * static_cast<double>(low.size()));
}

double CrossValidatedAuc(const Windows& first, const Windows& second, const WindowClassifierOptions& options) {
  if (options.folds < 2) throw std::invalid_argument("CrossValidatedAuc: at least two folds are needed");
  CheckSet(first, options.folds);
  CheckSet(second, options.folds);
  const Eigen::Index wanted = std::min(CountWindows(first), CountWindows(second));
  // Both sets are dealt by the same numbers: sets of equal clips are then cut and dealt alike.
  std::mt19937_64 first_rng(Mixed(options.seed, 0)), second_rng(Mixed(options.seed, 1));
  const Dealt sets[2] = {Deal(first, options.folds, wanted, first_rng), Deal(second, options.folds, wanted, second_rng)};
  const Eigen::Index values = sets[0].clip.front()->rows();
  for (const Dealt& set : sets) {
    for (const Eigen::MatrixXd* clip : set.clip) {
      if (clip->rows() != values) throw std::invalid_argument("CrossValidatedAuc: heights differ");
    }
  }

  std::vector<double> areas(options.folds, 0), pairs(options.folds, 0);
  ParallelFor(options.jobs, options.folds, [&](int fold) {
    std::vector<char> seen_labels, unseen_labels;
    std::vector<std::pair<const Eigen::MatrixXd*, Eigen::Index>> seen, unseen;
    for (char label = 0; label < 2; ++label) {
      const Dealt& set = sets[static_cast<int>(label)];
      for (size_t i = 0; i < set.fold.size(); ++i) {
        const bool left_out = set.fold[i] == fold;
        (left_out ? unseen : seen).emplace_back(set.clip[i], set.column[i]);
        (left_out ? unseen_labels : seen_labels).push_back(label);
      }
    }
    const auto ones = std::count(unseen_labels.begin(), unseen_labels.end(), 1);
    pairs[fold] = static_cast<double>(ones) * static_cast<double>(static_cast<std::ptrdiff_t>(unseen.size()) - ones);
    if (pairs[fold] == 0) return;  // all windows of a short fold were left out
    const auto gathered = [&](const auto& list) {
      Eigen::MatrixXf samples(values, static_cast<Eigen::Index>(list.size()));
      for (size_t i = 0; i < list.size(); ++i) {
        samples.col(static_cast<Eigen::Index>(i)) = list[i].first->col(list[i].second).template cast<float>();
      }
      return samples;
    };
    std::mt19937_64 rng(Mixed(options.seed, 2 + static_cast<std::uint64_t>(fold)));
    const RandomForest forest(gathered(seen), seen_labels, {.trees = options.trees}, rng);
    const Eigen::VectorXd scores = forest.Predict(gathered(unseen));
    std::vector<double> low, high;
    for (size_t i = 0; i < unseen.size(); ++i) (unseen_labels[i] ? high : low).push_back(scores[static_cast<Eigen::Index>(i)]);
    areas[fold] = AreaUnderCurve(low, high);
  });
  double sum = 0, weight = 0;
  for (int fold = 0; fold < options.folds; ++fold) sum += areas[fold] * pairs[fold], weight += pairs[fold];
  return weight > 0 ? sum / weight : 0.5;
}

Eigen::MatrixXd NoisyPoseWindows(const MotionClip& clip, double noise_m, std::uint64_t seed) {
  EvaluationMotion motion = PrepareEvaluation(clip);
  std::mt19937_64 rng(seed);
  boost::random::normal_distribution<double> normal(0, 1);
  for (Eigen::Matrix3Xd& positions : motion.joint_positions) {
    for (double& coordinate : positions.reshaped()) coordinate += noise_m * normal(rng);
  }
  return PoseWindows(motion);
}

double AreaAgainstHalf(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, const ClipHalves& halving,
                       const WindowClassifierOptions& options) {
  if (synthesised.empty()) throw std::invalid_argument("AreaAgainstHalf: no synthesised clip");
  std::vector<int> lengths;
  for (const int i : halving.first) lengths.push_back(AtEvaluationRate(captured.at(i)).frame_count());
  Windows second(halving.second.size());
  ParallelFor(options.jobs, static_cast<int>(second.size()), [&](int k) {
    const int i = halving.second[k];
    second[k] = NoisyPoseWindows(AtEvaluationRate(captured.at(i)), options.noise_m, CapturedSeed(options, i));
  });
  WindowClassifierOptions single = options;
  single.seed = HalvingSeed(options, 0);
  return CrossValidatedAuc(CutAlike(AtEvaluationRate(synthesised, options.jobs), lengths, options.noise_m, single.seed), second, single);
}

HalvedCapture::HalvedCapture(const std::vector<MotionClip>& captured, std::vector<ClipHalves> halvings, const WindowClassifierOptions& options)
    : halvings_(halvings.size()), options_(options) {
  if (halvings.empty()) throw std::invalid_argument("HalvedCapture: no halving");
  Windows windows(captured.size());
  std::vector<int> frames(captured.size());
  ParallelFor(options.jobs, static_cast<int>(captured.size()), [&](int i) {
    const MotionClip clip = AtEvaluationRate(captured[i]);
    frames[i] = clip.frame_count();
    windows[i] = NoisyPoseWindows(clip, options.noise_m, CapturedSeed(options, i));
  });
  const int count = static_cast<int>(halvings.size());
  ParallelFor(options.jobs, count, [&](int h) {
    Halving& halving = halvings_[h];
    const auto& [a, b] = halvings[h];
    halving.lengths = LengthsOf(frames, a);
    for (const int i : b) halving.against.push_back(windows.at(i));
    halving.classifier = options;
    halving.classifier.jobs = std::max(1, options.jobs / count);
    halving.classifier.seed = HalvingSeed(options, h);
    Windows first;
    for (const int i : a) first.push_back(windows.at(i));
    halving.windows = static_cast<int>(std::min(CountWindows(first), CountWindows(halving.against)));
    halving.floor = CrossValidatedAuc(first, halving.against, halving.classifier);
  });
}

HalvedCapture::HalvedCapture(const std::vector<MotionClip>& captured, const WindowClassifierOptions& options)
    : HalvedCapture(captured, RandomHalvings(captured.size(), options), options) {}

WindowDistinction HalvedCapture::Tell(const std::vector<MotionClip>& synthesised) const {
  if (synthesised.empty()) throw std::invalid_argument("HalvedCapture: no synthesised clip");
  const std::vector<MotionClip> drawn = AtEvaluationRate(synthesised, options_.jobs);
  const int count = static_cast<int>(halvings_.size());
  std::vector<double> areas(halvings_.size());
  ParallelFor(options_.jobs, count, [&](int h) {
    const Halving& halving = halvings_[h];
    areas[h] = CrossValidatedAuc(CutAlike(drawn, halving.lengths, options_.noise_m, halving.classifier.seed), halving.against, halving.classifier);
  });
  WindowDistinction result;
  double squares = 0;
  for (int h = 0; h < count; ++h) {
    result.auc += areas[h] / count;
    result.floor += halvings_[h].floor / count;
    result.windows += halvings_[h].windows / count;
  }
  result.difference = result.auc - result.floor;
  for (int h = 0; h < count; ++h) squares += std::pow(areas[h] - halvings_[h].floor - result.difference, 2);
  if (count > 1) result.standard_error = std::sqrt(squares / (count - 1) / count);
  return result;
}

WindowDistinction TellApart(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured,
                            const WindowClassifierOptions& options) {
  if (synthesised.empty()) throw std::invalid_argument("TellApart: no synthesised clip");
  return HalvedCapture(captured, options).Tell(synthesised);
}

}  // namespace morphograph
