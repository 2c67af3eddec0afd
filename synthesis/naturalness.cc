#include "synthesis/naturalness.h"

#include <stdexcept>
#include <string>

#include "primitives/frame_distance.h"

namespace morphograph {

std::vector<double> FrameDifferences(const Skeleton& skeleton,
                                     const std::vector<Eigen::Matrix3Xd>& joint_positions) {
  if (joint_positions.size() < 2) {
    throw std::invalid_argument("FrameDifferences: at least 2 frames are needed, not " +
                                std::to_string(joint_positions.size()));
  }
  const Eigen::VectorXd weights = FrameDistanceWeights(skeleton);
  std::vector<double> differences(joint_positions.size() - 1);
  for (size_t f = 0; f < differences.size(); ++f) {
    differences[f] = FrameDistance(joint_positions[f], joint_positions[f + 1], weights);
  }
  return differences;
}

double NaturalnessVariance(const std::vector<double>& frame_differences) {
  if (frame_differences.empty())
    throw std::invalid_argument("NaturalnessVariance: no frame difference given");
  const Eigen::Map<const Eigen::ArrayXd> values(frame_differences.data(),
                                                static_cast<Eigen::Index>(frame_differences.size()));
  return (values - values.mean()).square().mean();
}

}  // namespace morphograph
