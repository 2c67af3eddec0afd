#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

struct WindowClassifierOptions {
  int trees = 200;
  int folds = 5;
  double noise_m = 0.001;  // standard deviation of white noise on each coordinate of every joint
  int halvings = 6;        // random halves of the captured clips that figures are averaged over
  std::uint64_t seed = 1;  // of halves, cuts, noise, folds and forests
  int jobs = 1;            // threads; no figure depends on them
};

/// Chance that a random one of `high` is greater than a random one of `low`, ties half: the area under the receiver operating
/// characteristic, from mean ranks (Mann & Whitney 1947). @throws std::invalid_argument when either is empty.
double AreaUnderCurve(const std::vector<double>& low, const std::vector<double>& high);

/// How well a random forest tells two sets of windows apart: 0.5 not at all, 1 always (METHODS section 6).
///
/// Cross-validated by clip: all windows of a clip are in one fold, each set is dealt to the folds so that they hold about as many
/// windows. Of the larger set as many windows as the smaller one has are drawn first. The area under the curve is taken within each fold
/// and averaged, by its pairs: scores of different forests do not compare.
///
/// @param first, second  windows (values x N), a matrix a clip.
/// @throws std::invalid_argument when either set has fewer clips with windows than folds, or heights differ.
double CrossValidatedAuc(const std::vector<Eigen::MatrixXd>& first, const std::vector<Eigen::MatrixXd>& second,
                         const WindowClassifierOptions& options = {});

/// Pose windows of a clip at 30 fps with white noise on its joints.
///
/// The noise is drawn once for a frame and joint and added to the joint's place in the world, after the ground was found and
/// before windows are cut. So what windows take relative to the hips has the hips' noise in it too, the heading turns by about
/// 7 mrad (hip joints 20 cm apart), and the hips' speed gets 2 cm/s; overlapping windows share their noise.
Eigen::MatrixXd NoisyPoseWindows(const MotionClip& clip, double noise_m, std::uint64_t seed);

/// How well synthesised clips are told from captured ones, and how well captured ones are told from each other.
struct WindowDistinction {
  double auc = 0;          // synthesised against captured; mean over halves
  double floor = 0;        // captured against captured, the same numbers of windows
  double difference = 0;   // auc - floor, 0 is as good as captured
  double standard_error = 0;  // of the difference, over halves; 0 for a single one
  int windows = 0;         // of each set in a comparison; mean
};

/// Parts of the captured clips, as positions.
using ClipHalves = std::pair<std::vector<int>, std::vector<int>>;

/// How well synthesised clips are told from those of B, for one halving (A, B) of the captured clips: the first of the two comparisons that
/// HalvedCapture makes. @param halving  positions in `captured`. @return the area under the curve, 0.5 not at all, 1 always; options.halvings is
/// of no account. @throws std::invalid_argument when B or the synthesised clips cannot fill the folds with windows, or there is no synthesised clip.
double AreaAgainstHalf(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, const ClipHalves& halving,
                       const WindowClassifierOptions& options = {});

/// Captured clips and how well halves of them are told from each other, for any number of sets of synthesised clips to be judged by.
///
/// For every halving (A, B) of the captured clips two comparisons, alike in everything but the first set:
///   floor: A against B;
///   auc:   synthesised clips, cut to the lengths of A's clips one by one, against B.
/// The mean of each over the halves, and the mean and standard error of their differences.
///
/// Synthesised clips are taken in a random order and cut at random places; where there are fewer than captured ones, they are
/// taken again. Halves of the same captured clips are not independent, so the standard error says how much halving adds, not how
/// much another capture would differ.
class HalvedCapture {
 public:
  /// @param halvings  pairs of positions in `captured`; without them `options.halvings` random ones.
  /// @throws std::invalid_argument when a half has fewer clips that hold a window than there are folds, or there is no halving.
  HalvedCapture(const std::vector<MotionClip>& captured, std::vector<ClipHalves> halvings, const WindowClassifierOptions& options = {});
  HalvedCapture(const std::vector<MotionClip>& captured, const WindowClassifierOptions& options = {});

  /// @throws std::invalid_argument when there is no synthesised clip, or they cannot fill the folds with windows.
  WindowDistinction Tell(const std::vector<MotionClip>& synthesised) const;

 private:
  struct Halving {
    std::vector<int> lengths;              // of the clips of A, frames
    std::vector<Eigen::MatrixXd> against;  // windows of B, a matrix a clip
    WindowClassifierOptions classifier;
    double floor = 0;
    int windows = 0;  // of each set
  };

  std::vector<Halving> halvings_;
  WindowClassifierOptions options_;
};

/// The same for one set. @throws as both.
WindowDistinction TellApart(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured,
                            const WindowClassifierOptions& options = {});

}  // namespace morphograph
