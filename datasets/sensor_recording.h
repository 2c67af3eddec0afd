#pragma once

#include <Eigen/Core>

#include "datasets/readings.h"

namespace morphograph {

/// What inertial sensors recorded besides accelerations; a column a sample, lost values NaN. A matrix without rows: the file has none of it.
struct SensorRecording {
  Readings accelerations;         // m/s^2, gravity included, sensor's axes
  Eigen::MatrixXd rates_rad_s;    // (3 * sensors x samples), sensor's axes
  Eigen::MatrixXd orientations;   // (4 * sensors x samples): unit quaternions w, x, y, z, world_from_sensor, the source's world (Z up)
};

}  // namespace morphograph
