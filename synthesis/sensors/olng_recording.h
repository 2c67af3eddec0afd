#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "synthesis/sensors/olng_model.h"

namespace morphograph {

/// Motion from accelerations that are all there already: as OlngEstimator makes it, with paths that are joined backwards in time as well, so that what comes after a reading tells of it
/// as much as what came before.
///
/// A node of reading t and frame n costs c_t(n) + b_t(n) - d_t(n): what the best path costs that ends there (LazyNeighbourhoodGraph), what the best one costs that goes on
/// from there, found in the base and the readings played backwards, and once the distance that is in both; costs are found in blocks of readings, a few windows ahead, so that
/// only the I best paths of each are kept. A pose made of these paths goes on from the one made before. So poses are made twice, from the first reading to the last and from
/// the last to the first (PathPoser), and the result is midway between.
/// @param model  kEnergy or kWeightedMean. @param readings  (3 * sensors x frames). @return a pose a frame.
/// @throws std::invalid_argument for readings of another size or not finite, or another model.
std::vector<BasePose> ReconstructRecording(const std::shared_ptr<const OlngModel>& model, const Eigen::MatrixXd& readings);

}  // namespace morphograph
