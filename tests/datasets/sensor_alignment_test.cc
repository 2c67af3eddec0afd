#include "datasets/sensor_alignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "datasets/foot_strikes.h"
#include "datasets/readings_reader.h"
#include "datasets/synthetic_gait.h"
#include "datasets/virtual_sensors.h"
#include "tests/support/random_matrix.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

SyntheticGaitOptions WalkOptions() {
  SyntheticGaitOptions options;
  options.frame_rate_hz = 100;
  options.steps = 12;
  options.stand_s = 1.5;
  options.turns_rad = {0, 0, 0, 0.3, 0.3, 0.3, 0};
  return options;
}

const MotionClip& AlignedWalk(SyntheticGaitTruth* truth = nullptr) {
  static SyntheticGaitTruth made;
  static const MotionClip clip = GenerateGait(WalkOptions(), &made);
  if (truth) *truth = made;
  return clip;
}

constexpr double kDegree = 3.14159265358979 / 180;

TEST(SegmentFromMarkers, FollowsTheSegment) {
  const int knee = AlignedWalk().skeleton().FindRoleOrName("left_knee");
  std::vector<Placement> placements;
  for (const Vector3d& offset : {Vector3d(0.05, 0, 0), Vector3d(-0.04, -0.2, 0), Vector3d(0, -0.1, 0.06), Vector3d(0.02, -0.35, 0)}) {
    placements.push_back({"m" + std::to_string(placements.size()), "left_knee", offset, Quaterniond::Identity()});
  }
  const SegmentMotion found = SegmentFromMarkers(VirtualMarkers(AlignedWalk(), placements), {"m0", "m1", "m2", "m3"}), truth = SegmentOfJoint(AlignedWalk(), knee);
  ASSERT_EQ(found.sample_count(), truth.sample_count());
  EXPECT_NEAR(found.rate_hz, 100, 1e-6);
  const Eigen::Matrix3d constant = truth.rotations[0].transpose() * found.rotations[0];
  const Vector3d middle(0.0075, -0.1625, 0.015);
  for (int i = 0; i < found.sample_count(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    EXPECT_LT((truth.rotations[n] * constant - found.rotations[n]).norm(), 1e-6);
    EXPECT_LT((truth.positions.col(i) + truth.rotations[n] * middle - found.positions.col(i)).norm(), 1e-9);
  }
}

TEST(SegmentFromMarkers, RefusesWhatHasNoFrame) {
  Readings markers = VirtualMarkers(AlignedWalk(), {{"a", "hips", Vector3d(0, 0, 0), Quaterniond::Identity()},
                                             {"b", "hips", Vector3d(0, 0.1, 0), Quaterniond::Identity()},
                                             {"c", "hips", Vector3d(0, 0.3, 0), Quaterniond::Identity()},
                                             {"d", "hips", Vector3d(0.3, 0.3, 0), Quaterniond::Identity()}});
  EXPECT_THROW(SegmentFromMarkers(markers, {"a", "b"}), std::invalid_argument);
  EXPECT_THROW(SegmentFromMarkers(markers, {"a", "b", "c"}), std::invalid_argument);
  EXPECT_THROW(SegmentFromMarkers(markers, {"a", "b", "e"}), std::invalid_argument);
  EXPECT_EQ(SegmentFromMarkers(markers, {"a", "b", "d"}).sample_count(), AlignedWalk().frame_count());
  markers.values(0, 7) = std::nan("");
  EXPECT_THROW(SegmentFromMarkers(markers, {"a", "b", "d"}), std::invalid_argument);
}

// A virtual sensor put on anyhow is found where it was put.
TEST(AlignSensor, FindsMountingLeverAndDelay) {
  std::mt19937_64 rng(4);
  for (const char* joint : {"left_ankle", "right_knee", "left_wrist"}) {
    SCOPED_TRACE(joint);
    const Quaterniond mounting = testing::RandomRotation(rng);
    const Vector3d offset(0.03, -0.12, 0.05);
    const SegmentMotion segment = SegmentOfJoint(AlignedWalk(), AlignedWalk().skeleton().FindRoleOrName(joint));
    Readings readings = VirtualAccelerations(AlignedWalk(), {{"s", joint, offset, mounting}}, 100);
    SensorFaults faults;
    faults.noise = 0.3;
    readings = WithFaults(readings, faults, 1);
    Matrix3Xd late(3, readings.sample_count());
    for (int i = 0; i < late.cols(); ++i) late.col(i) = readings.values.col(std::max(0, i - 3));
    const SensorAlignment alignment = AlignSensor(segment, late);
    EXPECT_EQ(alignment.delay_samples, 3);
    EXPECT_LT(alignment.segment_from_sensor.angularDistance(mounting), 2 * kDegree);
    EXPECT_LT((alignment.offset_m - offset).norm(), 0.02);
    const AlignmentQuality quality = MeasureAlignment(segment, late, alignment, 20, segment.sample_count() - 20);
    EXPECT_GT(quality.correlation, 0.97);
    SensorAlignment wrong = alignment;
    wrong.segment_from_sensor = wrong.segment_from_sensor * Quaterniond(Eigen::AngleAxisd(0.5, Vector3d(1, 1, 0).normalized()));
    EXPECT_GT(MeasureAlignment(segment, late, wrong, 20, segment.sample_count() - 20).residual_m_s2, 3 * quality.residual_m_s2);
  }
}

TEST(AlignSensor, RefusesWhatItCannotAlign) {
  const SegmentMotion segment = SegmentOfJoint(AlignedWalk(), 0);
  EXPECT_THROW(AlignSensor(segment, Matrix3Xd::Zero(3, 20)), std::invalid_argument);
  EXPECT_THROW(AlignSensor(segment, Matrix3Xd::Constant(3, 200, std::nan(""))), std::invalid_argument);
  EXPECT_THROW(MeasureAlignment(segment, Matrix3Xd::Zero(3, 200), {}, 0, 200), std::invalid_argument);
  // A sensor that lies on the table has no lever arm and no delay; nothing breaks.
  const SensorAlignment resting = AlignSensor(segment, Vector3d(0, 9.81, 0).replicate(1, segment.sample_count()));
  EXPECT_TRUE(resting.offset_m.allFinite());
  EXPECT_NEAR(resting.segment_from_sensor.norm(), 1, 1e-9);
}

TEST(DelayByCorrelation, IsTheShift) {
  std::mt19937_64 rng(5);
  const Eigen::MatrixXd signal = testing::RandomNormal(2, 200, rng);
  for (const int delay : {-7, -1, 0, 4}) EXPECT_EQ(DelayByCorrelation(signal.middleCols(20, 150), signal.middleCols(20 - delay, 150), 10), delay);
  EXPECT_EQ(DelayByCorrelation(Eigen::MatrixXd::Ones(1, 50), Eigen::MatrixXd::Ones(1, 50), 10), 0);
}

TEST(MountingByMoments, IsFoundFromAnotherWalkersReadings) {
  SyntheticGaitOptions other = WalkOptions();
  other.seed = 9;
  other.speed_m_s = 1.15;
  other.stature_m = 1.65;
  other.steps = 20;
  const MotionClip walker = GenerateGait(other);
  std::mt19937_64 rng(6);
  for (const char* joint : {"left_wrist", "right_wrist", "left_ankle", "right_ankle"}) {
    SCOPED_TRACE(joint);
    const Quaterniond mounting = testing::RandomRotation(rng);
    const Matrix3Xd reference = VirtualAccelerations(AlignedWalk(), PlacementsAtJoints({joint}), 30).values;
    const Matrix3Xd sensor = VirtualAccelerations(walker, {{"s", joint, Vector3d::Zero(), mounting}}, 30).values;
    EXPECT_LT(MountingByMoments(reference, sensor).angularDistance(mounting), 20 * kDegree);
  }
}

TEST(FootStrikeTimes, AreThoseOfAWalkThatIsKnown) {
  SyntheticGaitTruth truth;
  const MotionClip& clip = AlignedWalk(&truth);
  for (const auto& [foot, joint] : {std::pair{Foot::kLeft, "left_ankle"}, {Foot::kRight, "right_ankle"}}) {
    const Matrix3Xd readings = VirtualAccelerations(clip, PlacementsAtJoints({joint}), 100).values;
    const std::vector<double> found = FootStrikeTimes(readings, 100);
    std::size_t strikes = 0, near = 0;
    for (const SyntheticGaitTruth::Strike& strike : truth.strikes) {
      if (strike.foot != foot) continue;
      ++strikes;
      double nearest = 1e9;
      for (const double time : found) nearest = std::min(nearest, std::abs(time - strike.time_s));
      EXPECT_LT(nearest, 0.16) << strike.time_s;
      near += nearest < 0.06;
    }
    // The generator's feet land without a blow, so one or the other is found with the slap of the sole.
    EXPECT_GE(near + 1, strikes);
    EXPECT_NEAR(static_cast<double>(found.size()), static_cast<double>(strikes), 1);
  }
  EXPECT_TRUE(FootStrikeTimes(Vector3d(0, 9.81, 0).replicate(1, 500), 100).empty());
  EXPECT_TRUE(FootStrikeTimes(Matrix3Xd(3, 0), 100).empty());
}

TEST(StillPhases, AreWhereABodyStands) {
  const Matrix3Xd readings = VirtualAccelerations(AlignedWalk(), PlacementsAtJoints({"hips"}), 100).values;
  const auto phases = StillPhases(readings, 100, 1.0);
  ASSERT_EQ(phases.size(), 2u);
  EXPECT_EQ(phases.front().first, 0);
  EXPECT_EQ(phases.back().second, readings.cols() - 1);
}

TEST(AlignSensor, ReachesTheFigureOnRealSensors) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::filesystem::path data = testing::SharedData() / "real_imu/neura_s02";
  const Readings sensors = ReadReadings(data / "imu_raw").readings, markers = ReadReadings(data / "S02-Trial-Walk-1_vicon_markers.csv").readings;
  for (const auto& [sensor, names] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"L_Foot", {"LANK", "LHEE", "LTOE", "LAJC"}}, {"R_LowLeg", {"RKNE", "RTIB", "RANK"}}}) {
    const auto row = 3 * (std::find(sensors.names.begin(), sensors.names.end(), sensor) - sensors.names.begin());
    const SegmentMotion segment = SegmentFromMarkers(markers, names);
    const Matrix3Xd readings = sensors.values.middleRows<3>(row);
    const SensorAlignment alignment = AlignSensor(segment, readings);
    EXPECT_EQ(alignment.delay_samples, 2);
    const AlignmentQuality walking = MeasureAlignment(segment, readings, alignment, 1111, 2122);
    EXPECT_LE(walking.residual_m_s2, 2.3);
    EXPECT_GE(walking.correlation, 0.82);
  }
}

}  // namespace
}  // namespace morphograph
