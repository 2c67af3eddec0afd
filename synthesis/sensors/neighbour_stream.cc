#include "synthesis/sensors/neighbour_stream.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace morphograph {

const std::vector<Neighbour>& NeighbourStream::Next(const Eigen::VectorXd& reading) {
  const Eigen::VectorXf query = model_->scale().cwiseProduct(reading.cast<float>());
  // The K frames that were nearest to the last reading are no farther from this one than then and the way between the readings together.
  float bound = std::numeric_limits<float>::infinity();
  if (query_.size() != 0) {
    const float radius = (farthest_ + (query - query_).norm()) * 1.0001F + 1e-6F;
    bound = radius * radius;
  }
  model_->search().Nearest(query, model_->options().neighbours, &nearest_, bound);
  query_ = query;
  farthest_ = std::sqrt(std::max_element(nearest_.begin(), nearest_.end())->squared_distance);
  return nearest_;
}

}  // namespace morphograph
