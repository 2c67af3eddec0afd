#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "synthesis/control/chained_sensor.h"
#include "synthesis/control/residuals/control_residuals.h"

namespace morphograph {

/// Virtual accelerometers on a step against readings (Xie 2009, Eq. 6.4; Tautges 2011, Eq. 10 with the tilt that the pose has): for each reading
///   (S^T ((p(t - h) - 2 p(t) + p(t + h)) / h^2 - g) - reading) / sigma,
/// p the sensor's place in the world, S its axes, h the step of the readings. The same second difference as VirtualAccelerations().
class SensorResidual : public StepResidual {
 public:
  /// @param first_s  time in the clip of the first of the readings, which follow each other at `rate_hz`.
  /// @param readings  (3 * sensors x samples), m/s^2. @param sigma_m_s2  deviation of a reading.
  SensorResidual(std::shared_ptr<const StepKinematics> step, std::vector<ChainedSensor> sensors, double first_s, double rate_hz, Eigen::MatrixXd readings,
                 double sigma_m_s2);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::vector<ChainedSensor> sensors_;
  double first_s_, rate_hz_;
  Eigen::MatrixXd readings_;
  double sigma_m_s2_;
};

}  // namespace morphograph
