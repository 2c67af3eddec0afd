#pragma once

#include <memory>
#include <vector>

#include "synthesis/sensors/lazy_neighbourhood_graph.h"
#include "synthesis/sensors/motion_base.h"
#include "synthesis/sensors/neighbour_search.h"
#include "synthesis/sensors/neighbourhood_energy.h"
#include "synthesis/sensors/pose_estimator.h"

namespace morphograph {

/// How a pose is made of what the base says.
enum class OlngPose {
  kEnergy,        // of least energy among the neighbours
  kWeightedMean,  // the mean of the ends of the best paths
  kNearest,       // the frame with the nearest reading, without paths: the baseline
};

/// Copies of other tempos that a base for this method does well to hold. A body that moves a fifth slower reads a third less beyond gravity: its readings are then not
/// near its own style's, and paths through the base, which may go on at another tempo, are not found.
inline constexpr double kOlngTempos[] = {0.85, 1.15};

struct OlngOptions {
  int neighbours = 0;  // K; 0: a share of the base, see OlngModel
  int paths = 0;       // I; 0: a share of the base
  LazyNeighbourhoodOptions graph;
  /// Readings are compared after each sensor's are divided by the standard deviation of what it reads over the base, to this power: 0 leaves m/s^2, and then
  /// ankles, which are shaken most, count most; 1 makes all count alike.
  double sensor_exponent = 0;
  OlngPose pose = OlngPose::kEnergy;
  NeighbourhoodEnergyOptions energy;
};

/// What the method knows: the base and an index of its readings. Immutable; may serve several streams at once.
class OlngModel {
 public:
  /// Where the options leave them open, K is 0.75 % of the base's frames and 256 or more, I 0.025 % and within [24, 256]. Copies of other tempos are near to all the
  /// same readings: they raise K, least number included, but not I. K is 4096 at most.
  /// @throws std::invalid_argument for a base without sensors, or options out of range.
  OlngModel(std::shared_ptr<const MotionBase> base, const OlngOptions& options);

  const MotionBase& base() const { return *base_; }
  const OlngOptions& options() const { return options_; }  // with K and I filled in
  const NeighbourSearch& search() const { return *search_; }
  /// What readings are multiplied with before they are compared, (3 * sensors).
  const Eigen::VectorXf& scale() const { return scale_; }
  /// For every frame of the base whether the one before it is of the same clip, as LazyNeighbourhoodGraph wants it; backwards: frames numbered from the end.
  std::vector<char> Follows(bool backwards) const;
  /// Joints next to sensors, as places in the base's measured joints, each once.
  const std::vector<int>& controlled() const { return controlled_; }
  /// The sensor of each of these.
  const std::vector<int>& controlling() const { return controlling_; }

 private:
  std::shared_ptr<const MotionBase> base_;
  OlngOptions options_;
  Eigen::VectorXf scale_;
  std::unique_ptr<const NeighbourSearch> search_;
  std::vector<int> controlled_, controlling_;
};

/// Frames of the base whose readings are nearest, for one reading of a stream after the other.
class NeighbourStream {
 public:
  explicit NeighbourStream(std::shared_ptr<const OlngModel> model) : model_(std::move(model)) {}
  /// In no particular order; valid until the next call. @param reading  (3 * sensors), finite.
  const std::vector<Neighbour>& Next(const Eigen::VectorXd& reading);

 private:
  std::shared_ptr<const OlngModel> model_;
  std::vector<Neighbour> nearest_;
  Eigen::VectorXf query_;  // the reading before; empty at first
  float farthest_ = 0;     // distance of its K-th neighbour
};

/// Motion from a stream of accelerations by the online lazy neighbourhood graph (Tautges et al. 2011): nearest readings of the base, joined to paths; the pose is that of
/// least energy under priors from the ends of the best paths; the root goes as theirs do on the average, faster or slower as the paths do.
///
/// Departures: priors are regularised normal distributions unless PriorKind::kKernel asks for the published kernels. Eq. 1 takes the (I+1)-th cost for the largest, so that no path is left without weight and I = 1 is defined. Eq. 6 as printed lands one frame late; with
/// -1/2 a dt^2 it is the difference of the neighbour's last two frames. Eq. 9 is centred at t, and so are the accelerations it is compared with. Eq. 10 takes velocities
/// at the paths' previous frames, and for gravity the tilt of the pose before, which the neighbours gave. Velocities and accelerations are scaled by the
/// tempo of the path and its square. Terms that go on from the pose before gain their weight as paths do: after t readings 1 - (1 - 1/M)^t of it, for the first poses
/// of a stream are little more than guesses.
class OlngEstimator : public PoseEstimator {
 public:
  explicit OlngEstimator(std::shared_ptr<const OlngModel> model);

  /// Poses from the first reading on. @throws std::invalid_argument for a reading of another size, or not finite.
  BasePose Next(const Eigen::VectorXd& reading) override;
  /// The same with the paths that end in this frame told, as ReconstructRecording() finds them. @param paths  in any order, at least one, each ending in a frame of
  /// the base. @throws std::invalid_argument as above, for other paths, or where the model is to take the nearest frame alone.
  BasePose Next(const Eigen::VectorXd& reading, std::vector<NeighbourPath> paths);

  /// The paths that the last pose was made of, best first, and their weights. Empty after kNearest.
  const std::vector<NeighbourPath>& best_paths() const { return best_; }
  const Eigen::VectorXd& weights() const { return weights_; }

 private:
  void Check(const Eigen::VectorXd& reading) const;
  void KeepBest(std::vector<NeighbourPath> paths);
  NeighbourhoodTargets Targets() const;

  std::shared_ptr<const OlngModel> model_;
  LazyNeighbourhoodGraph graph_;
  NeighbourStream neighbours_;
  std::vector<NeighbourPath> best_;
  Eigen::VectorXd weights_;
  double trust_ = 0;                    // in the pose before
  Eigen::VectorXd reading_, rotations_;  // of the frame before; empty at first
  Eigen::VectorXd positions_, older_positions_;
};

}  // namespace morphograph
