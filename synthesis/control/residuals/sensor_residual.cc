#include "synthesis/control/residuals/sensor_residual.h"

#include "datasets/virtual_sensors.h"

namespace morphograph {

SensorResidual::SensorResidual(std::shared_ptr<const StepKinematics> step, std::vector<ChainedSensor> sensors, double first_s, double rate_hz,
                               Eigen::MatrixXd readings, double sigma_m_s2)
    : StepResidual(std::move(step), static_cast<int>(readings.size())),
      sensors_(std::move(sensors)),
      first_s_(first_s),
      rate_hz_(rate_hz),
      readings_(std::move(readings)),
      sigma_m_s2_(sigma_m_s2) {}

StepResidual::Linear SensorResidual::Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const {
  const Eigen::Index samples = readings_.cols(), dimension = w.size();
  std::vector<const JointChain*> chains;
  for (const ChainedSensor& sensor : sensors_) chains.push_back(sensor.chain.get());

  // Where each sensor is in every sample, and in the ones before and behind.
  struct Reading {
    Eigen::Vector3d position_m;
    Eigen::Matrix3d rotation;  // world_from_sensor
    Eigen::MatrixXd position, turn;  // (3 x dimension + 4), by latent and place
  };
  std::vector<std::vector<Reading>> there(sensors_.size());
  for (Eigen::Index n = -1; n <= samples; ++n) {
    const std::vector<PointState> joints = step().Joints(chains, {true, first_s_ + static_cast<double>(n) / rate_hz_}, w, place);
    for (size_t s = 0; s < sensors_.size(); ++s) {
      const PointState& joint = joints[s];
      const Eigen::Vector3d arm = joint.rotation * sensors_[s].place.offset_m;
      Reading& reading = there[s].emplace_back();
      reading.position_m = joint.position_m + arm;
      reading.rotation = joint.rotation * sensors_[s].place.joint_from_sensor.toRotationMatrix();
      reading.turn.resize(3, dimension + 4);
      reading.turn << joint.turn_by_latent, joint.turn_by_place;
      reading.position.resize(3, dimension + 4);
      reading.position << joint.position_by_latent, joint.position_by_place;
      if (arm.isZero(0)) continue;
      for (Eigen::Index c = 0; c < reading.turn.cols(); ++c) reading.position.col(c) += Eigen::Vector3d(reading.turn.col(c)).cross(arm);
    }
  }

  Linear linear;
  linear.value.resize(readings_.size());
  linear.by_latent.resize(readings_.size(), dimension);
  linear.by_place.resize(readings_.size(), 4);
  const double scale = rate_hz_ * rate_hz_;
  for (Eigen::Index n = 0; n < samples; ++n) {
    for (size_t s = 0; s < sensors_.size(); ++s) {
      const auto at = static_cast<size_t>(n) + 1;
      const Reading &before = there[s][at - 1], &now = there[s][at], &after = there[s][at + 1];
      Eigen::Vector3d force = scale * (before.position_m - 2 * now.position_m + after.position_m);
      force.y() += kGravity_m_s2;
      Eigen::MatrixXd by = scale * (before.position - 2 * now.position + after.position);
      // The sensor's axes turned by d read R^T (f - d x f).
      for (Eigen::Index c = 0; c < by.cols(); ++c) by.col(c) += force.cross(Eigen::Vector3d(now.turn.col(c)));
      const Eigen::Index row = n * readings_.rows() + 3 * static_cast<Eigen::Index>(s);
      linear.value.segment<3>(row) = (now.rotation.transpose() * force - readings_.block<3, 1>(3 * static_cast<Eigen::Index>(s), n)) / sigma_m_s2_;
      const Eigen::MatrixXd turned = now.rotation.transpose() * by / sigma_m_s2_;
      linear.by_latent.middleRows<3>(row) = turned.leftCols(dimension);
      linear.by_place.middleRows<3>(row) = turned.rightCols<4>();
    }
  }
  return linear;
}

}  // namespace morphograph
