#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "datasets/error_reason.h"
#include "synthesis/evaluation.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/frechet_distance.h"
#include "synthesis/pose_windows.h"
#include "synthesis/window_space.h"

namespace morphograph {
namespace {

constexpr int kMinWindows = 64;  // two per direction
constexpr int kHalvings = 20;    // random halves of the reference that are averaged
constexpr int kDiversityPairs = 20000;

using Windows = std::vector<Eigen::MatrixXd>;  // a matrix a clip

int WindowCount(const Windows& clips) {
  Eigen::Index count = 0;
  for (const Eigen::MatrixXd& clip : clips) count += clip.cols();
  return static_cast<int>(count);
}

// Fréchet distance between two random halves of the clips (not of the windows: neighbours overlap).
double HalvesDistance(const Windows& projected, std::mt19937_64& rng) {
  double sum = 0;
  for (int round = 0; round < kHalvings; ++round) {
    std::vector<size_t> order(projected.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    for (size_t i = order.size(); i > 1; --i) {
      std::swap(order[i - 1], order[boost::random::uniform_int_distribution<size_t>(0, i - 1)(rng)]);
    }
    Windows halves[2];
    for (size_t i = 0; i < order.size(); ++i) halves[i % 2].push_back(projected[order[i]]);
    sum += FrechetDistance(FitGaussian(JoinColumns(halves[0])), FitGaussian(JoinColumns(halves[1])));
  }
  return sum / kHalvings;
}

// Mean distance of random pairs of windows; all pairs would be 10^8 for a large set.
double Diversity(const Eigen::MatrixXd& windows, std::mt19937_64& rng) {
  boost::random::uniform_int_distribution<Eigen::Index> any(0, windows.cols() - 1);
  double sum = 0;
  for (int i = 0; i < kDiversityPairs; ++i) {
    const Eigen::Index a = any(rng);
    Eigen::Index b = any(rng);
    while (b == a) b = any(rng);
    sum += (windows.col(a) - windows.col(b)).norm();
  }
  return sum / kDiversityPairs;
}

}  // namespace

SetComparison CompareWindowSets(const Windows& clips, const Windows& reference, std::uint64_t seed) {
  SetComparison comparison;
  comparison.windows = WindowCount(clips);
  comparison.windows_reference = WindowCount(reference);
  for (const auto& [set, count] : {std::pair{"the clips", comparison.windows}, std::pair{"the reference", comparison.windows_reference}}) {
    if (count < kMinWindows) {
      throw std::invalid_argument("CompareSets: " + std::string(set) + " yield too few windows of half a second: " +
                                  std::to_string(count) + ", and " + std::to_string(kMinWindows) + " are needed");
    }
  }
  Windows filled;  // clips shorter than a window have none and cannot be dealt into halves
  for (const Eigen::MatrixXd& clip : reference) {
    if (clip.cols() > 0) filled.push_back(clip);
  }
  if (filled.size() < 4)
    throw std::invalid_argument("CompareSets: the reference needs four clips or more to be halved");

  const WindowSpace space(JoinColumns(filled));
  Windows projected;
  for (const Eigen::MatrixXd& clip : filled) projected.push_back(space.Project(clip));
  const Eigen::MatrixXd of_reference = JoinColumns(projected);
  const Eigen::MatrixXd joined_clips = JoinColumns(clips);
  const Eigen::MatrixXd of_clips = space.Project(joined_clips);

  std::mt19937_64 rng(seed);
  comparison.frechet = FrechetDistance(FitGaussian(of_clips), FitGaussian(of_reference));
  comparison.frechet_halves = HalvesDistance(projected, rng);
  comparison.frechet_ratio = comparison.frechet / comparison.frechet_halves;
  comparison.residual_ratio =
      space.MeanSquaredResidual(joined_clips) / space.MeanSquaredResidual(JoinColumns(filled));
  comparison.diversity = Diversity(of_clips, rng);
  comparison.diversity_reference = Diversity(of_reference, rng);
  return comparison;
}

SetComparison CompareSets(const std::vector<MotionClip>& clips, const std::vector<MotionClip>& reference,
                          std::uint64_t seed) {
  Windows of_clips, of_reference;
  const auto add = [](const MotionClip& clip, Windows* windows) {
    try {
      windows->push_back(PoseWindows(PrepareEvaluation(clip)));
    } catch (const std::invalid_argument& unfit) {
      throw std::invalid_argument("CompareSets: clip '" + clip.name + "': " + ReasonOf(unfit));
    }
  };
  for (const MotionClip& clip : clips) add(clip, &of_clips);
  for (const MotionClip& clip : reference) add(clip, &of_reference);
  return CompareWindowSets(of_clips, of_reference, seed);
}

}  // namespace morphograph
