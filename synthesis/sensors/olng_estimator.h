#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "synthesis/sensors/neighbour_stream.h"
#include "synthesis/sensors/olng_model.h"
#include "synthesis/sensors/path_poser.h"
#include "synthesis/sensors/pose_estimator.h"

namespace morphograph {

/// Motion from a stream of accelerations by the online lazy neighbourhood graph (Tautges et al. 2011): nearest readings of the base, joined to paths, and a pose of these by
/// PathPoser. One reading in, one pose out.
class OlngEstimator : public PoseEstimator {
 public:
  explicit OlngEstimator(std::shared_ptr<const OlngModel> model);

  /// Poses from the first reading on. @throws std::invalid_argument for a reading of another size, or not finite.
  BasePose Next(const Eigen::VectorXd& reading) override;

  /// Makes the poses of paths, and tells which the last was made of; none with kNearest.
  const std::optional<PathPoser>& poser() const { return poser_; }

 private:
  std::shared_ptr<const OlngModel> model_;
  LazyNeighbourhoodGraph graph_;
  NeighbourStream neighbours_;
  std::optional<PathPoser> poser_;
};

}  // namespace morphograph
