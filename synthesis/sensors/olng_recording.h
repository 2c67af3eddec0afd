#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "synthesis/sensors/olng_model.h"

namespace morphograph {

/// Motion from accelerations that are all there already: as OlngEstimator makes it, but what comes after a reading tells of its pose as much as what came before.
///
/// Paths: a node of reading t and frame n costs c_t(n) + b_t(n) - d_t(n): what the best path costs that ends there (LazyNeighbourhoodGraph), what the best one costs that
/// goes on from there, found in the base and the readings played backwards, and once the distance that is in both. These costs are found in blocks of readings, a few windows
/// ahead, and the I best paths of each reading are kept.
///
/// Poses: PathPoser's go on from those made before, so they are made twice, from the first reading to the last and from the last to the first. The result lies between the
/// two; each counts as far as its pose before was trusted.
///
/// @param model  kEnergy or kWeightedMean. @param readings  (3 * sensors x frames). @return a pose a frame.
/// @throws std::invalid_argument for readings of another size or not finite, or another model.
std::vector<BasePose> ReconstructRecording(const std::shared_ptr<const OlngModel>& model, const Eigen::MatrixXd& readings);

}  // namespace morphograph
