#include "datasets/virtual_sensors.h"

#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "datasets/forward_kinematics.h"
#include "datasets/resample.h"

namespace morphograph {
namespace {

void CheckFault(double value, const char* name) {
  if (!(value >= 0) || !std::isfinite(value)) throw std::invalid_argument(std::string("WithFaults: ") + name + " must be 0 or more");
}

Readings EmptyReadings(const MotionClip& clip, const std::vector<Placement>& placements) {
  Readings readings;
  for (const Placement& placement : placements) readings.names.push_back(placement.name);
  for (int f = 0; f < clip.frame_count(); ++f) readings.times_s.push_back(f / clip.frame_rate_hz());
  readings.values.resize(3 * static_cast<Eigen::Index>(placements.size()), clip.frame_count());
  return readings;
}

// One engine a kind of fault, so that each draws the same numbers whatever the others do.
std::mt19937_64 EngineOf(std::uint64_t seed, std::uint64_t kind) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), static_cast<std::uint32_t>(kind)};
  return std::mt19937_64(sequence);
}

}  // namespace

Readings VirtualAccelerations(const MotionClip& recorded, const std::vector<Placement>& placements, double rate_hz) {
  const MotionClip clip = Resample(recorded, rate_hz);
  if (clip.frame_count() < 3) throw std::invalid_argument("VirtualAccelerations: fewer than 3 samples at this rate");
  const std::vector<int> joints = JointsOf(placements, clip.skeleton());
  Readings readings = EmptyReadings(clip, placements);
  const Eigen::Index sensors = static_cast<Eigen::Index>(placements.size());
  Eigen::MatrixXd positions(3 * sensors, clip.frame_count());
  std::vector<Eigen::Quaterniond> turns(static_cast<std::size_t>(sensors) * static_cast<std::size_t>(clip.frame_count()));
  WorldPose pose;
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    for (Eigen::Index s = 0; s < sensors; ++s) {
      const auto n = static_cast<std::size_t>(s);
      const Eigen::Quaterniond& rotation = pose.rotations[static_cast<std::size_t>(joints[n])];
      positions.col(f).segment<3>(3 * s) = pose.positions.col(joints[n]) + rotation * placements[n].offset_m;
      turns[static_cast<std::size_t>(f) * placements.size() + n] = rotation * placements[n].joint_from_sensor;
    }
  }
  const Eigen::Vector3d upward(0, kGravity_m_s2, 0);
  for (int f = 0; f < clip.frame_count(); ++f) {
    const int middle = std::min(std::max(f, 1), clip.frame_count() - 2);
    for (Eigen::Index s = 0; s < sensors; ++s) {
      const auto position = [&](int frame) -> Eigen::Vector3d { return positions.col(frame).segment<3>(3 * s); };
      const Eigen::Vector3d acceleration = (position(middle + 1) - 2 * position(middle) + position(middle - 1)) * (rate_hz * rate_hz);
      const Eigen::Quaterniond& turn = turns[static_cast<std::size_t>(f) * placements.size() + static_cast<std::size_t>(s)];
      readings.values.col(f).segment<3>(3 * s) = turn.conjugate() * (acceleration + upward);
    }
  }
  return readings;
}

Readings VirtualMarkers(const MotionClip& clip, const std::vector<Placement>& placements) {
  const std::vector<int> joints = JointsOf(placements, clip.skeleton());
  Readings readings = EmptyReadings(clip, placements);
  WorldPose pose;
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    for (std::size_t s = 0; s < placements.size(); ++s) {
      readings.values.col(f).segment<3>(3 * static_cast<Eigen::Index>(s)) =
          pose.positions.col(joints[s]) + pose.rotations[static_cast<std::size_t>(joints[s])] * placements[s].offset_m;
    }
  }
  return readings;
}

Readings WithFaults(const Readings& readings, const SensorFaults& faults, std::uint64_t seed) {
  CheckFault(faults.noise, "noise");
  CheckFault(faults.bias, "bias");
  CheckFault(faults.mounting_rad, "mounting");
  CheckFault(faults.range, "range");
  CheckFault(faults.loss, "loss");
  if (faults.loss >= 1) throw std::invalid_argument("WithFaults: loss must be below 1");
  Readings faulty = readings;
  Eigen::MatrixXd& values = faulty.values;
  const Eigen::Index sensors = readings.sensor_count();
  boost::random::normal_distribution<double> normal;
  boost::random::uniform_real_distribution<double> uniform(0, 1);
  std::mt19937_64 mounting = EngineOf(seed, 1), bias = EngineOf(seed, 2), noise = EngineOf(seed, 3), loss = EngineOf(seed, 4);
  for (Eigen::Index s = 0; s < sensors; ++s) {
    normal.reset();
    Eigen::Vector3d axis(normal(mounting), normal(mounting), normal(mounting));
    const double angle = faults.mounting_rad * normal(mounting);
    const Eigen::Matrix3d turn = axis.norm() > 0 ? Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix() : Eigen::Matrix3d::Identity();
    normal.reset();
    const Eigen::Vector3d error = faults.bias * Eigen::Vector3d(normal(bias), normal(bias), normal(bias));
    if (faults.mounting_rad > 0) values.middleRows<3>(3 * s) = (turn * values.middleRows<3>(3 * s)).eval();
    values.middleRows<3>(3 * s).colwise() += error;
  }
  normal.reset();
  for (Eigen::Index f = 0; f < values.cols(); ++f) {
    for (Eigen::Index r = 0; r < values.rows(); ++r) {
      values(r, f) += faults.noise * normal(noise);
      if (faults.range > 0) values(r, f) = std::min(std::max(values(r, f), -faults.range), faults.range);
    }
    for (Eigen::Index s = 0; s < sensors; ++s) {
      if (uniform(loss) < faults.loss) values.col(f).segment<3>(3 * s).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return faulty;
}

}  // namespace morphograph
