#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph {

struct TimeWarpOptions {
  int max_slope = 5;  // horizontal, or vertical, steps allowed in a row (Du 3.2.2); >= 0
};

/// A reference frame and the test frame that goes with it.
struct WarpCell {
  int reference = 0;
  int test = 0;
  friend bool operator==(const WarpCell&, const WarpCell&) = default;
};

/// A warping curve: from (0, 0) to the last frames of both, each cell one step from the one before.
struct WarpPath {
  std::vector<WarpCell> cells;
  double cost = 0;  // sum of the costs of its cells
};

/// True when segments of these lengths can be matched at all under the slope limit.
bool CanWarp(int reference_frames, int test_frames, const TimeWarpOptions& options = {});

/// The cheapest warping curve that is monotone and continuous, keeps both end points and takes at most
/// `max_slope` horizontal, or vertical, steps in a row (Du 3.2.2).
///
/// Differs from Du's Algorithm 1: run lengths are part of the state, so the curve is the best one under the
/// limit (the printed search is greedy), and the limit holds at the border too.
///
/// @param cost  (reference frames x test frames), finite; e.g. FrameDistanceMatrix.
/// @throws std::invalid_argument when `cost` is empty or not finite, or CanWarp is false.
WarpPath DynamicTimeWarp(const Eigen::MatrixXd& cost, const TimeWarpOptions& options = {});

/// Index of the segment with the least mean distance to the others (Du 3.2), the first of equals.
/// @param pairwise_distances  (segments x segments); row i holds the distances of segment i.
int ChooseReference(const Eigen::MatrixXd& pairwise_distances);

/// A smooth, strictly increasing map from canonical phase to source phase, both with 0 at the first and 1 at the
/// second key frame.
///
/// The logarithm of its slope is piecewise linear between knots spaced uniformly over canonical [0, 1] and
/// normalised so that 0 goes to 0 and 1 to 1: whatever the log slopes, time runs forward. Outside [0, 1]
/// the slope at the border goes on, for segments with margins.
class TimeWarp {
 public:
  /// Uniform time.
  TimeWarp() : TimeWarp(Eigen::VectorXd::Zero(2)) {}

  /// @param log_slopes  (knots >= 2), finite; a common constant cancels.
  static TimeWarp FromLogSlopes(const Eigen::VectorXd& log_slopes) { return TimeWarp(log_slopes); }

  /// Least-squares fit to a warping curve, at sub-frame precision.
  ///
  /// Minimises mean((warp(reference phase) - test phase)^2) + regularisation * mean(log slope^2) over the cells and
  /// over phase, by Gauss-Newton. A curve of whole frames is a stair; the second term, which draws towards
  /// uniform time, keeps the stairs out. About 1e-3 suits segments of 16 to 20 frames: the variance of rounding to frames,
  /// 1 / (12 * 16^2) over some 20 cells, against log slopes of about 0.15.
  ///
  /// @param knots  >= 2
  /// @param regularisation  > 0
  static TimeWarp Fit(const WarpPath& path, int reference_frames, int test_frames, int knots, double regularisation);

  int knots() const { return static_cast<int>(log_slopes_.size()); }
  /// Log slopes (knots), normalised: the slope integrates to 1 over [0, 1].
  const Eigen::VectorXd& log_slopes() const { return log_slopes_; }

  /// Source phase at a canonical phase.
  double operator()(double canonical_phase) const;
  /// d source phase / d canonical phase, > 0.
  double Slope(double canonical_phase) const;
  /// Canonical phase at a source phase; exact inverse of operator().
  double Inverse(double source_phase) const;
  /// d source phase / d log slopes at a canonical phase, (knots); for the slopes as they were given, normalised or not.
  Eigen::VectorXd Gradient(double canonical_phase) const;

 private:
  explicit TimeWarp(const Eigen::VectorXd& log_slopes);

  Eigen::VectorXd log_slopes_;
  Eigen::VectorXd at_knots_;  // source phase at every knot; 0 first, 1 last
};

}  // namespace morphograph
