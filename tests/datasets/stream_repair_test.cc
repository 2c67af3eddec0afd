#include "datasets/stream_repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>

#include "datasets/dataset_loader.h"
#include "datasets/errors.h"
#include "datasets/live_repair.h"
#include "datasets/synthetic_gait.h"
#include "datasets/virtual_sensors.h"
#include "tests/support/random_matrix.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const MotionClip& Walk() {
  static const MotionClip clip = [] {
    SyntheticGaitOptions options;
    options.frame_rate_hz = 120;
    options.steps = 16;
    return GenerateGait(options);
  }();
  return clip;
}

const Readings& Clean(double rate_hz = 60) {
  static const auto placements = PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"});
  static const Readings at_60 = VirtualAccelerations(Walk(), placements, 60), at_30 = VirtualAccelerations(Walk(), placements, 30);
  return rate_hz == 60 ? at_60 : at_30;
}

Readings Without(const Readings& readings, const std::set<int>& rows) {
  Readings kept = readings;
  kept.times_s.clear();
  Eigen::Index n = 0;
  for (int i = 0; i < readings.sample_count(); ++i) {
    if (rows.count(i)) continue;
    kept.times_s.push_back(readings.times_s[static_cast<std::size_t>(i)]);
    kept.values.col(n++) = readings.values.col(i);
  }
  kept.values.conservativeResize(Eigen::NoChange, n);
  return kept;
}

double Rms(const Eigen::MatrixXd& values) { return std::sqrt(values.squaredNorm() / static_cast<double>(values.size())); }

std::string AllNotes(const RepairedReadings& repaired) {
  std::string text;
  for (const std::string& note : repaired.notes) text += note + "\n";
  return text;
}

TEST(StreamRepair, LeavesAGoodStreamAsItIs) {
  const RepairedReadings repaired = RepairStream(Clean());
  EXPECT_NEAR(repaired.rate_hz, 60, 1e-6);
  EXPECT_THAT(repaired.notes, IsEmpty());
  EXPECT_THAT(repaired.dead_sensors, IsEmpty());
  ASSERT_EQ(repaired.readings.values.cols(), Clean().values.cols());
  EXPECT_EQ(repaired.readings.values, Clean().values);
  EXPECT_NEAR(repaired.lost_share, 0, 1e-12);
}

TEST(StreamRepair, ToALowerRateItIsWhatTheBaseHas) {
  StreamRepairOptions options;
  options.rate_hz = 30;
  const RepairedReadings repaired = RepairStream(Clean(60), options);
  const Eigen::MatrixXd& expected = Clean(30).values;
  ASSERT_EQ(repaired.readings.values.cols(), expected.cols());
  // Seen from the sensors, which turn between samples; the ends lack half of their triangle.
  const Eigen::Index inner = expected.cols() - 4;
  const double size = Rms((expected.middleCols(2, inner).colwise() - expected.rowwise().mean()));
  EXPECT_LT(Rms(repaired.readings.values.middleCols(2, inner) - expected.middleCols(2, inner)), 0.15 * size);
  // Without the average it is much further off.
  Eigen::MatrixXd plain(expected.rows(), expected.cols());
  for (Eigen::Index i = 0; i < expected.cols(); ++i) plain.col(i) = Clean(60).values.col(2 * i);
  EXPECT_GT(Rms(plain - expected), 2 * Rms(repaired.readings.values - expected));
}

TEST(StreamRepair, TheTriangleIsExactForSecondDifferences) {
  // Without turning, accelerations at 30 Hz are the triangle's average of those at 90 Hz to the last digit.
  std::mt19937_64 rng(2);
  const Eigen::MatrixXd positions = 0.0002 * testing::RandomNormal(3, 273, rng);
  Readings fine;
  fine.names = {"s"};
  fine.values.resize(3, 271);
  for (int i = 0; i < 271; ++i) {
    fine.times_s.push_back(i / 90.0);
    fine.values.col(i) = (positions.col(i + 2) - 2 * positions.col(i + 1) + positions.col(i)) * 8100 + Eigen::Vector3d(0, 9.81, 0);
  }
  StreamRepairOptions options;
  options.rate_hz = 30;
  const RepairedReadings repaired = RepairStream(fine, options);
  ASSERT_EQ(repaired.spike_share, 0) << AllNotes(repaired);
  for (int i = 1; i < 90; ++i) {
    const Eigen::Vector3d expected = (positions.col(3 * i + 4) - 2 * positions.col(3 * i + 1) + positions.col(3 * i - 2)) * 900 + Eigen::Vector3d(0, 9.81, 0);
    EXPECT_LT((repaired.readings.values.col(i) - expected).norm(), 1e-8);
  }
}

TEST(StreamRepair, ToAHigherRateItRunsThroughTheSamples) {
  StreamRepairOptions options;
  options.rate_hz = 120;
  const RepairedReadings repaired = RepairStream(Clean(60), options);
  ASSERT_EQ(repaired.readings.sample_count(), 2 * Clean(60).sample_count() - 1);
  for (Eigen::Index i = 0; i < Clean(60).values.cols(); ++i) EXPECT_LT((repaired.readings.values.col(2 * i) - Clean(60).values.col(i)).norm(), 1e-9);
}

TEST(StreamRepair, BridgesLostPacketsAndSaysHowMany) {
  SensorFaults faults;
  faults.loss = 0.1;
  const RepairedReadings repaired = RepairStream(WithFaults(Clean(), faults, 3));
  EXPECT_TRUE(repaired.readings.values.allFinite());
  EXPECT_NEAR(repaired.lost_share, 0.1, 0.02);
  EXPECT_THAT(AllNotes(repaired), HasSubstr("never came"));
  const double size = Rms(Clean().values.colwise() - Clean().values.rowwise().mean());
  EXPECT_LT(Rms(repaired.readings.values - Clean().values), 0.12 * size);

  // Packets that are missing altogether do the same.
  std::set<int> rows;
  std::mt19937_64 rng(4);
  for (int i = 1; i + 1 < Clean().sample_count(); ++i) {
    if (testing::RandomUniform(0, 1, rng) < 0.1) rows.insert(i);
  }
  const RepairedReadings shorter = RepairStream(Without(Clean(), rows));
  EXPECT_EQ(shorter.readings.sample_count(), Clean().sample_count());
  EXPECT_NEAR(shorter.lost_share, 0.1, 0.03);
  EXPECT_LT(Rms(shorter.readings.values - Clean().values), 0.12 * size);
}

TEST(StreamRepair, UnevenTimesAreMadeSteady) {
  // A smooth motion read at times that wander.
  std::mt19937_64 rng(6);
  Readings readings;
  readings.names = {"a"};
  const auto at = [](double t) { return Eigen::Vector3d(4 * std::sin(6 * t), 9.81 + 3 * std::cos(9 * t), 2 * std::sin(4 * t + 1)); };
  std::vector<Eigen::Vector3d> values;
  for (double t = 0; t < 5; t += 0.01 * testing::RandomUniform(0.5, 1.5, rng)) {
    readings.times_s.push_back(t);
    values.push_back(at(t));
  }
  readings.values.resize(3, static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) readings.values.col(static_cast<Eigen::Index>(i)) = values[i];
  StreamRepairOptions options;
  options.rate_hz = 100;
  const RepairedReadings repaired = RepairStream(readings, options);
  EXPECT_THAT(AllNotes(repaired), HasSubstr("uneven"));
  for (int i = 0; i < repaired.readings.sample_count(); ++i) EXPECT_LT((repaired.readings.values.col(i) - at(i / 100.0)).norm(), 0.02);
}

TEST(StreamRepair, FillsALongGapWithTheMeanAndTellsWhere) {
  Readings readings = Clean();
  readings.values.block(3, 300, 3, 31).setConstant(kNan);
  const RepairedReadings repaired = RepairStream(readings);
  EXPECT_THAT(AllNotes(repaired), HasSubstr("'right_wrist' is silent from 4.98 s to 5.52 s; filled with its mean"));
  EXPECT_NEAR(repaired.longest_gap_s, 31 / 60.0, 1e-6);
  EXPECT_TRUE(repaired.readings.values.allFinite());
  const Eigen::Vector3d mean = Clean().values.middleRows<3>(3).rowwise().mean();
  EXPECT_LT((repaired.readings.values.block<3, 1>(3, 315) - mean).norm(), 0.25 * (Clean().values.block<3, 1>(3, 299) - mean).norm() + 0.3);
  EXPECT_EQ(repaired.readings.values.block(0, 0, 3, Clean().sample_count()), Clean().values.topRows<3>());
}

TEST(StreamRepair, AllSensorsMaySilenceTogether) {
  std::set<int> rows;
  for (int i = 200; i < 230; ++i) rows.insert(i);
  const RepairedReadings repaired = RepairStream(Without(Clean(), rows));
  EXPECT_EQ(repaired.readings.sample_count(), Clean().sample_count());
  EXPECT_NEAR(repaired.longest_gap_s, 0.5, 1e-6);
}

TEST(StreamRepair, ReplacesSpikesAndNothingElse) {
  Readings readings = Clean();
  for (const int i : {50, 121, 122, 300, 411}) readings.values.col(i).segment<3>(6) += Eigen::Vector3d(120, -90, 60);
  readings.values(0, 77) = 1e29;
  const RepairedReadings repaired = RepairStream(readings);
  EXPECT_THAT(AllNotes(repaired), HasSubstr("'left_ankle': 5 wild samples"));
  EXPECT_THAT(AllNotes(repaired), HasSubstr("'left_wrist': 1 wild samples"));
  EXPECT_LT((repaired.readings.values - Clean().values).cwiseAbs().maxCoeff(), 25);
  EXPECT_LT(Rms(repaired.readings.values - Clean().values), 0.3);
}

TEST(StreamRepair, TellsClipping) {
  SensorFaults faults;
  faults.range = 1.5 * 9.81;
  const RepairedReadings repaired = RepairStream(WithFaults(Clean(), faults, 1));
  EXPECT_THAT(AllNotes(repaired), HasSubstr("_ankle' is clipped at 14.7 m/s^2"));
  EXPECT_GT(repaired.clipped_share, 0.005);
  EXPECT_EQ(RepairStream(Clean()).clipped_share, 0);
}

// Blows at half the samples' distance touch the range for a sample each.
TEST(StreamRepair, TellsClippingOfShortBlows) {
  Readings readings = Clean();
  for (int i = 50; i + 1 < readings.sample_count(); i += 70) {
    readings.values.block(1, i - 1, 1, 3).setConstant(24);  // a blow of three samples, no spike
    readings.values(1, i) = 29.43;
  }
  EXPECT_THAT(AllNotes(RepairStream(readings)), HasSubstr("is clipped at 29.4 m/s^2"));
}

TEST(StreamRepair, DoubtsTimesAndUnitsThatCannotBe) {
  Readings readings = Clean();
  for (double& time_s : readings.times_s) time_s *= 1000;
  EXPECT_THROW(RepairStream(readings), DatasetError);
  readings = Clean();
  readings.values /= 0.3048;
  EXPECT_THAT(AllNotes(RepairStream(readings)), HasSubstr("are they in m/s^2?"));
}

// All kinds of motion that there are: none is taken for readings in another unit.
TEST(StreamRepair, DoubtsNoRecordedMotion) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<Placement> sensors = PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle", "hips"});
  for (const char* folder : {"bnr/dataset-2/run", "cmu/09", "cmu/05", "cmu/131"}) {
    for (const LoadedClip& loaded : LoadDataset({testing::SharedData() / folder}).clips) {
      if (loaded.clip.duration_s() < 0.5) continue;
      EXPECT_THAT(AllNotes(RepairStream(VirtualAccelerations(loaded.clip, sensors, 60))), Not(HasSubstr("are they in m/s^2?"))) << loaded.clip.name;
    }
  }
}

TEST(StreamRepair, FindsUnits) {
  for (const double factor : {1 / 9.81, 1000 / 9.81}) {
    Readings readings = Clean();
    readings.values *= factor;
    const RepairedReadings repaired = RepairStream(readings);
    EXPECT_NEAR(repaired.unit_factor, 1 / factor, 1e-9);
    EXPECT_THAT(AllNotes(repaired), HasSubstr("not m/s^2"));
    EXPECT_LT((repaired.readings.values - Clean().values).cwiseAbs().maxCoeff(), 1e-9);
  }
  StreamRepairOptions options;
  options.kind = ReadingsKind::kMarkers;
  const Readings markers = VirtualMarkers(Walk(), PlacementsAtJoints({"hips", "head", "left_ankle", "right_ankle"}));
  Readings scaled = markers;
  scaled.values *= 1000;
  const RepairedReadings repaired = RepairStream(scaled, options);
  EXPECT_EQ(repaired.unit_factor, 0.001);
  EXPECT_LT((repaired.readings.values - markers.values).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(StreamRepair, NamesDeadSensorsWhateverTheyDied) {
  std::mt19937_64 rng(8);
  const auto dead = [&](const std::function<void(Eigen::Ref<Eigen::MatrixXd>)>& kill) {
    Readings readings = Clean();
    kill(readings.values.middleRows<3>(3));
    const RepairedReadings repaired = RepairStream(readings);
    EXPECT_THAT(repaired.dead_sensors, ElementsAre(1)) << AllNotes(repaired);
    EXPECT_TRUE(repaired.readings.values.middleRows<3>(3).isZero());
    EXPECT_EQ(repaired.readings.values.topRows<3>(), Clean().values.topRows<3>());
    return AllNotes(repaired);
  };
  EXPECT_THAT(dead([](auto rows) { rows.setConstant(kNan); }), HasSubstr("'right_wrist' says nothing at all; it is left out"));
  EXPECT_THAT(dead([](auto rows) { rows.rightCols(rows.cols() - 5).setConstant(kNan); }), HasSubstr("hardly anything"));
  EXPECT_THAT(dead([](auto rows) { rows.colwise() = Eigen::Vector3d(0, 9.81, 0); }), HasSubstr("the same all the time"));
  EXPECT_THAT(dead([](auto rows) { rows.setZero(); }), HasSubstr("the same all the time"));
  EXPECT_THAT(dead([&](auto rows) { rows = 0.5 * testing::RandomNormal(3, rows.cols(), rng); }), HasSubstr("shows no gravity"));
  EXPECT_THAT(dead([&](auto rows) { rows = 6 * testing::RandomNormal(3, rows.cols(), rng); }), HasSubstr("is noise"));
  EXPECT_THAT(dead([](auto rows) { rows.array() *= 30; }), HasSubstr("shows no gravity"));
}

TEST(StreamRepair, ASensorThatStopsIsLostFromThereOn) {
  Readings readings = Clean();
  for (int i = 300; i < readings.sample_count(); ++i) readings.values.block<3, 1>(6, i) = readings.values.block<3, 1>(6, 300);
  const RepairedReadings repaired = RepairStream(readings);
  EXPECT_THAT(repaired.dead_sensors, IsEmpty());
  EXPECT_THAT(AllNotes(repaired), HasSubstr("'left_ankle' says the same from 5.00 s"));
  EXPECT_GT(repaired.lost_share, 0.05);
}

std::string ErrorOf(const Readings& readings, const StreamRepairOptions& options = {}) {
  try {
    RepairStream(readings, options, "a.csv");
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "no error";
}

TEST(StreamRepair, SaysWhenNothingCanBeMadeOfIt) {
  Readings readings = Clean();
  readings.values.setConstant(kNan);
  EXPECT_THAT(ErrorOf(readings), HasSubstr("a.csv: no sensor is alive: 'left_wrist' says nothing at all, 'right_wrist'"));
  readings.values = Clean().values;
  for (int s = 0; s < 4; ++s) readings.values.row(3 * s + 1).array() -= 9.81;
  readings.values *= 0.02;
  EXPECT_THAT(ErrorOf(readings), HasSubstr("accelerations with gravity are needed"));
  readings = Clean();
  for (double& time : readings.times_s) time *= 1e6;
  EXPECT_THAT(ErrorOf(readings), HasSubstr("more than a day"));
  readings = Clean();
  readings.times_s.back() = 80000;
  EXPECT_THAT(ErrorOf(readings), HasSubstr("hardly anything in 80000 s"));
  std::set<int> rows;
  for (int i = 2; i < Clean().sample_count(); ++i) rows.insert(i);
  EXPECT_THAT(ErrorOf(Without(Clean(), rows)), HasSubstr("fewer than 3 samples"));
  EXPECT_THAT(ErrorOf(Readings()), HasSubstr("no sensor"));
  readings = Clean();
  std::swap(readings.times_s[3], readings.times_s[4]);
  EXPECT_THROW(RepairStream(readings), std::invalid_argument);
  StreamRepairOptions options;
  options.rate_hz = -1;
  EXPECT_THROW(RepairStream(Clean(), options), std::invalid_argument);
}

TEST(StreamRepair, MarkersAreBridgedStraight) {
  StreamRepairOptions options;
  options.kind = ReadingsKind::kMarkers;
  const Readings markers = VirtualMarkers(Walk(), PlacementsAtJoints({"hips", "head", "left_ankle", "right_ankle"}));
  Readings holed = markers;
  holed.values.block(3, 300, 3, 60).setConstant(kNan);
  holed.values.block(0, 100, 3, 1).array() += 0.8;
  const RepairedReadings repaired = RepairStream(holed, options);
  EXPECT_THAT(AllNotes(repaired), HasSubstr("'head' is silent from 2.49 s to 3.00 s; bridged straight"));
  EXPECT_LT((repaired.readings.values - markers.values).cwiseAbs().maxCoeff(), 0.06);
}

// Any mixture of damage gives finite readings or an error that says why.
TEST(StreamRepair, SurvivesAnyMixtureOfDamage) {
  int repaired_streams = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    std::mt19937_64 rng(seed);
    SensorFaults faults;
    faults.loss = testing::RandomUniform(0, 0.98, rng) * (seed % 3 > 0);
    faults.noise = testing::RandomUniform(0, 30, rng) * (seed % 2);
    faults.range = seed % 5 == 0 ? 3 * 9.81 : 0;
    Readings readings = WithFaults(Clean(), faults, seed);
    readings.values *= std::pow(10, testing::RandomUniform(-4, 4, rng) * (seed % 4 == 0));
    for (int n = 0; n < 30; ++n) {
      const auto row = static_cast<Eigen::Index>(testing::RandomUniform(0, 12, rng)), column = static_cast<Eigen::Index>(testing::RandomUniform(0, 500, rng));
      readings.values(row, column) = n % 3 == 0 ? 1e300 : n % 3 == 1 ? std::numeric_limits<double>::infinity() : kNan;
    }
    for (std::size_t i = 1; i < readings.times_s.size(); ++i) readings.times_s[i] += seed % 7 == 0 ? 0.3 * std::floor(static_cast<double>(i) / 50) : 0;
    StreamRepairOptions options;
    options.rate_hz = testing::RandomUniform(1, 200, rng);
    options.cutoff_hz = seed % 2 ? 10 : 0;
    options.kind = seed % 6 == 5 ? ReadingsKind::kMarkers : ReadingsKind::kAccelerations;
    try {
      const RepairedReadings repaired = RepairStream(readings, options);
      EXPECT_TRUE(repaired.readings.values.allFinite()) << seed;
      EXPECT_EQ(repaired.readings.values.cols(), repaired.readings.sample_count());
      EXPECT_FALSE(repaired.notes.empty()) << seed;
      ++repaired_streams;
    } catch (const DatasetError& error) {
      EXPECT_GT(std::string(error.what()).size(), 20u);
    }
  }
  EXPECT_GT(repaired_streams, 15);
}

TEST(StreamRepair, FindsLittleWrongWithRealSensors) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::filesystem::path data = testing::SharedData() / "real_imu";
  for (const char* file : {"neura_s02/imu_raw", "gaitmap_healthy/imu_sample.csv", "ipol_gait/1-4", "ipol_gait/7-1"}) {
    const Readings readings = ReadReadings(data / file).readings;
    const RepairedReadings repaired = RepairStream(readings);
    SCOPED_TRACE(std::string(file) + "\n" + AllNotes(repaired));
    EXPECT_THAT(repaired.dead_sensors, IsEmpty());
    EXPECT_EQ(repaired.unit_factor, 1);
    EXPECT_LT(repaired.spike_share, 0.003);
    if (std::string(file) == "ipol_gait/7-1") {
      EXPECT_NEAR(repaired.lost_share, 0.1, 0.02);
    } else {
      EXPECT_LT(repaired.lost_share, 0.003);
    }
  }
}

Eigen::MatrixXd Live(const Readings& readings, LiveRepair* repair, double* slowest_s = nullptr) {
  std::vector<Eigen::VectorXd> results;
  for (int i = 0; i < readings.sample_count(); ++i) {
    const double time_s = readings.times_s[static_cast<std::size_t>(i)];
    for (Eigen::VectorXd& result : repair->Push(time_s, readings.values.col(i))) {
      results.push_back(std::move(result));
      const double lateness_s = time_s - readings.times_s[0] - static_cast<double>(results.size() - 1) / 30;
      if (slowest_s && static_cast<double>(results.size()) / 30 > 1) *slowest_s = std::max(*slowest_s, lateness_s);
    }
  }
  for (Eigen::VectorXd& result : repair->Finish()) results.push_back(std::move(result));
  Eigen::MatrixXd values(readings.values.rows(), static_cast<Eigen::Index>(results.size()));
  for (std::size_t i = 0; i < results.size(); ++i) values.col(static_cast<Eigen::Index>(i)) = results[i];
  return values;
}

TEST(LiveRepair, SaysWhatTheWholeStreamsRepairSays) {
  LiveRepair repair({"left_wrist", "right_wrist", "left_ankle", "right_ankle"});
  double slowest_s = 0;
  const Eigen::MatrixXd live = Live(Clean(), &repair, &slowest_s);
  StreamRepairOptions options;
  options.rate_hz = 30;
  const Eigen::MatrixXd whole = RepairStream(Clean(), options).readings.values;
  ASSERT_EQ(live.cols(), whole.cols());
  EXPECT_LT((live - whole).leftCols(live.cols() - 2).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT(slowest_s, 0);
  EXPECT_LT(slowest_s, repair.delay_s() + 1 / 60.0 + 1e-6);
  EXPECT_LT(repair.delay_s(), 0.2);
  EXPECT_THAT(repair.notes(), IsEmpty());
  EXPECT_THAT(repair.dead_sensors(), IsEmpty());
}

TEST(LiveRepair, BearsLossSpikesUnitsAndLateSamples) {
  SensorFaults faults;
  faults.loss = 0.1;
  Readings readings = WithFaults(Clean(), faults, 5);
  for (int i = 40; i < readings.sample_count(); i += 90) readings.values.col(i).head<3>().setConstant(140);
  readings.values /= 9.81;
  readings.values.block(9, 200, 3, 400).setConstant(kNan);
  LiveRepair repair({"left_wrist", "right_wrist", "left_ankle", "right_ankle"});
  EXPECT_THAT(repair.Push(-1, readings.values.col(0)), IsEmpty());
  const Eigen::MatrixXd live = Live(readings, &repair);
  EXPECT_THAT(repair.notes(), Contains(HasSubstr("in g, not")));
  EXPECT_TRUE(live.allFinite());
  EXPECT_GT(repair.wild_samples(), readings.sample_count() / 90 - 2);
  EXPECT_THAT(repair.Push(0, readings.values.col(0)), IsEmpty());
  EXPECT_EQ(repair.late_samples(), 1);
}

TEST(LiveRepair, KnowsWhichSensorsAreDeadAtThisMoment) {
  Readings readings = Clean();
  LiveRepair repair({"left_wrist", "right_wrist", "left_ankle", "right_ankle"});
  for (int i = 0; i < 450; ++i) {
    Eigen::VectorXd values = readings.values.col(i);
    if (i >= 150) values.segment<3>(3).setConstant(kNan);
    if (i >= 150) values.segment<3>(6) = readings.values.col(150).segment<3>(6);
    repair.Push(readings.times_s[static_cast<std::size_t>(i)], values);
    if (i == 140 || i == 200) {
      EXPECT_THAT(repair.dead_sensors(), IsEmpty());
    }
  }
  EXPECT_THAT(repair.dead_sensors(), ElementsAre(1, 2));
  for (int i = 450; i < 460; ++i) repair.Push(readings.times_s[static_cast<std::size_t>(i)], readings.values.col(i));
  EXPECT_THAT(repair.dead_sensors(), IsEmpty());
}

TEST(LiveRepair, StartsAnewAfterALongSilenceAndRefusesNonsense) {
  LiveRepair repair({"wrist"});
  const Eigen::Vector3d rest(0, 9.81, 0);
  std::size_t results = 0;
  for (int i = 0; i < 100; ++i) results += repair.Push(i / 60.0, rest).size();
  const std::vector<Eigen::VectorXd> rest_of_it = repair.Push(1e6, rest);
  EXPECT_EQ(results + rest_of_it.size(), 50u);
  for (int i = 1; i < 100; ++i) {
    for (const Eigen::VectorXd& result : repair.Push(1e6 + i / 60.0, rest)) EXPECT_LT((result - rest).norm(), 1e-6);
  }
  EXPECT_THAT(repair.notes(), Contains(HasSubstr("started anew")));
  EXPECT_THROW(repair.Push(2e6, Eigen::VectorXd::Zero(6)), std::invalid_argument);
  EXPECT_THROW(repair.Push(kNan, rest), std::invalid_argument);
  EXPECT_THROW(LiveRepair(std::vector<std::string>()), std::invalid_argument);
  LiveRepair silent({"wrist"});
  EXPECT_THAT(silent.Finish(), IsEmpty());
  for (int i = 0; i < 100; ++i) {
    for (const Eigen::VectorXd& result : silent.Push(i / 60.0, Eigen::Vector3d::Constant(kNan))) EXPECT_TRUE(result.isZero());
  }
  EXPECT_THAT(silent.dead_sensors(), ElementsAre(0));
}

std::string Joined(const std::vector<std::string>& notes) {
  std::string all;
  for (const std::string& note : notes) all += note + "\n";
  return all;
}

const std::vector<std::string> kFour = {"left_wrist", "right_wrist", "left_ankle", "right_ankle"};

// Results of the samples of Clean(), each at the time that is told of it.
int ResultsOf(LiveRepair* repair, const std::function<double(int)>& time_s, const std::function<void(int, Eigen::VectorXd*)>& damage = {}) {
  int results = 0;
  const auto count = [&](const std::vector<Eigen::VectorXd>& due) {
    for (const Eigen::VectorXd& result : due) EXPECT_TRUE(result.allFinite());
    results += static_cast<int>(due.size());
  };
  for (int i = 0; i < Clean().sample_count(); ++i) {
    Eigen::VectorXd values = Clean().values.col(i);
    if (damage) damage(i, &values);
    count(repair->Push(time_s(i), values));
  }
  count(repair->Finish());
  return results;
}

TEST(LiveRepair, FollowsClocksThatAreSetBackOrLeapOnce) {
  const int whole = (Clean().sample_count() - 1) / 2 + 1;
  LiveRepair back(kFour);
  EXPECT_GT(ResultsOf(&back, [](int i) { return i < 300 ? 100 + i / 60.0 : i / 60.0; }), whole - 25);
  EXPECT_THAT(Joined(back.notes()), HasSubstr("set back from 104.98 s"));
  LiveRepair leap(kFour);
  EXPECT_GT(ResultsOf(&leap, [](int i) { return i == 300 ? 1e6 : i / 60.0; }), whole - 40);
  LiveRepair pauses(kFour);  // the first, before enough has come to begin with
  EXPECT_GT(ResultsOf(&pauses, [](int i) { return i / 60.0 + (i >= 3 ? 12 : 0) + (i >= 400 ? 12 : 0) + (i >= 405 ? 12 : 0); }), whole - 25);
}

TEST(LiveRepair, RefusesTimesThatAreNotInSeconds) {
  for (const double unit : {1e3, 1e-9}) {
    LiveRepair repair(kFour);
    EXPECT_THROW(ResultsOf(&repair, [&](int i) { return unit * i / 60; }), std::invalid_argument) << unit;
  }
  // A median of next to nothing would ask for endless averages.
  LiveRepair bursts(kFour);
  EXPECT_THROW(ResultsOf(&bursts, [](int i) { return i < 11 ? 1e-15 * i : 0.6 + i / 60.0; }), std::invalid_argument);
}

TEST(LiveRepair, SensorsThatWakeLateLiveAndStallsOfAllKillNone) {
  LiveRepair late(kFour);
  ResultsOf(&late, [](int i) { return i / 60.0; }, [](int i, Eigen::VectorXd* values) {
    if (i < 40) values->head<3>().setZero();
  });
  EXPECT_THAT(late.dead_sensors(), IsEmpty());
  EXPECT_THAT(Joined(late.notes()), HasSubstr("'left_wrist' is of use again"));
  // Each sensor on lines of its own, and two seconds in which none comes.
  LiveRepair stall(kFour);
  for (int i = 0; i < 4 * Clean().sample_count(); ++i) {
    Eigen::VectorXd values = Eigen::VectorXd::Constant(12, kNan);
    values.segment<3>(3 * (i % 4)) = Clean().values.col(i / 4).segment<3>(3 * (i % 4));
    stall.Push(i / 240.0 + (i >= 1200 ? 2 : 0), values);
  }
  EXPECT_THAT(Joined(stall.notes()), Not(HasSubstr("left out")));
  EXPECT_THAT(Joined(stall.notes()), HasSubstr("was silent from"));
}

// A person who stands: readings of a coarse sensor say the same for seconds.
TEST(LiveRepair, StandingKillsNoCoarseSensor) {
  std::mt19937_64 rng(3);
  LiveRepair repair(kFour);
  const auto coarse = [&](Eigen::VectorXd values) {
    const double step = 0.01 * 9.81;
    for (double& value : values) value = step * std::round((value + 0.005 * testing::RandomUniform(-1, 1, rng)) / step);
    return values;
  };
  for (int i = 0; i < 1500; ++i) repair.Push(i / 60.0, coarse(Clean().values.col(std::min(i, 300))));
  EXPECT_THAT(repair.dead_sensors(), IsEmpty());
  EXPECT_LT(repair.notes().size(), 5u) << Joined(repair.notes());
}

TEST(LiveRepair, TellsNoMoreOfHoursThanOfMinutes) {
  LiveRepair repair({"wrist", "ankle"});
  for (int i = 0; i < 200'000; ++i) {
    const double phase = i / 10.0;
    repair.Push(i / 30.0 + 0.4 * (i / 50) + (i / 5000) * 11.0,
                (Eigen::VectorXd(6) << std::sin(phase), 9.81, 0, 0, 9.81 + 3 * std::cos(phase), i % 1000 < 500 ? std::sin(phase) : kNan).finished());
  }
  EXPECT_LT(repair.notes().size(), 100u);
}

TEST(LiveRepair, MarkersBeyondAllMeasureAreWild) {
  const Readings markers = VirtualMarkers(Walk(), PlacementsAtJoints({"hips", "head", "left_ankle", "right_ankle"}));
  LiveRepair repair(kFour, {.kind = ReadingsKind::kMarkers});
  for (int i = 0; i < markers.sample_count(); ++i) {
    Eigen::VectorXd values = markers.values.col(i);
    if (i == 90 || i == 91) values.head<3>().setConstant(1e300);
    for (const Eigen::VectorXd& result : repair.Push(markers.times_s[static_cast<std::size_t>(i)], values)) EXPECT_LT(result.cwiseAbs().maxCoeff(), 100);
  }
  EXPECT_EQ(repair.wild_samples(), 2);
}

// Feet of runners are thrown about by several g: none of their sensors is dead, and their blows are no spikes.
TEST(StreamRepair, LeavesSensorsOfRunnersAlive) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<std::filesystem::path> folders;
  for (const char* folder : {"bnr/dataset-2/run", "cmu/09"}) {
    if (std::filesystem::exists(testing::SharedData() / folder)) folders.push_back(testing::SharedData() / folder);
  }
  if (folders.empty()) GTEST_SKIP() << "no recordings of runs there";
  for (const LoadedClip& loaded : LoadDataset(folders).clips) {
    for (const double rate_hz : {30.0, 100.0}) {
      const auto placements = PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle", "hips", "head", "left_toe", "left_knee"});
      const RepairedReadings repaired = RepairStream(VirtualAccelerations(loaded.clip, placements, rate_hz), {.rate_hz = 30});
      EXPECT_THAT(repaired.dead_sensors, IsEmpty()) << loaded.clip.name << " at " << rate_hz << ": " << ::testing::PrintToString(repaired.notes);
      EXPECT_EQ(repaired.unit_factor, 1) << loaded.clip.name;
      EXPECT_LT(repaired.spike_share, 0.003) << loaded.clip.name << " at " << rate_hz;
    }
  }
}

}  // namespace
}  // namespace morphograph
