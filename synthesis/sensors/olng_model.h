#pragma once

#include <memory>
#include <vector>

#include "synthesis/sensors/lazy_neighbourhood_graph.h"
#include "synthesis/sensors/motion_base.h"
#include "synthesis/sensors/neighbour_search.h"
#include "synthesis/sensors/neighbourhood_energy.h"

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

/// Which way time goes while paths are joined or poses made, one after the other.
enum class TimeDirection { kForwards, kBackwards };

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
  /// For every frame of the base whether the one before it is of the same clip, as LazyNeighbourhoodGraph wants it; backwards: frames are numbered from the end.
  std::vector<char> Follows(TimeDirection direction) const;
  /// Joints next to sensors, as places in the base's measured joints, each once.
  const std::vector<int>& controlled() const { return controlled_; }
  /// The sensor of each of these.
  const std::vector<int>& controlling() const { return controlling_; }
  /// @throws std::invalid_argument for a reading that is not of the base's sensors, or not finite.
  void Check(const Eigen::VectorXd& reading) const;

 private:
  std::shared_ptr<const MotionBase> base_;
  OlngOptions options_;
  Eigen::VectorXf scale_;
  std::unique_ptr<const NeighbourSearch> search_;
  std::vector<int> controlled_, controlling_;
};

}  // namespace morphograph
