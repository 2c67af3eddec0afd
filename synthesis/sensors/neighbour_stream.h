#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "synthesis/sensors/olng_model.h"

namespace morphograph {

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

}  // namespace morphograph
