#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "synthesis/sensors/olng_estimator.h"

namespace morphograph {

/// Motion from accelerations that are all there already: OlngEstimator with paths that are joined backwards in time as well, so that what comes after a reading tells of it
/// as much as what came before.
///
/// A node of reading t and frame n costs c_t(n) + b_t(n) - d_t(n): what the best path costs that ends there (LazyNeighbourhoodGraph), what the best one costs that goes on
/// from there, found in the base and the readings played backwards, and once the distance that is in both. Poses are then made one after the other as those of a stream are.
///
/// Readings are gone through in blocks, a few windows ahead, so that memory does not grow with them.
/// @param model  kEnergy or kWeightedMean. @param readings  (3 * sensors x frames). @return a pose a frame.
/// @throws std::invalid_argument for readings of another size, or not finite.
std::vector<BasePose> ReconstructRecording(const std::shared_ptr<const OlngModel>& model, const Eigen::MatrixXd& readings);

}  // namespace morphograph
