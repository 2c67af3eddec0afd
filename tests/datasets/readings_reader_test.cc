// Every format of readings: what it means, where it is wrong, and the real files.
#include "datasets/readings_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/errors.h"
#include "datasets/foot_sensor_reader.h"
#include "datasets/marker_csv_reader.h"
#include "datasets/marker_units.h"
#include "datasets/trc_reader.h"
#include "datasets/xsens_reader.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::string ReaderErrorOf(const std::string& text) {
  try {
    ParseReadings(text, "a");
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "no error";
}

std::string Trc(const std::string& unit, const std::string& rows) {
  return "PathFileType\t4\t(X/Y/Z)\ta.trc\r\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\r\n 100\t100\t2\t2\t " + unit +
         "\t100\r\nFrame#\tTime\tR.Heel\t\t\tL.Toe\t\t\t\t\r\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\r\n\r\n" + rows;
}

TEST(TrcReader, ReadsMetresFromAnyUnit) {
  for (const auto& [unit, metres] : {std::pair<const char*, double>{"m", 1}, {"cm", 0.01}, {"mm", 0.001}}) {
    const Readings markers = ParseTrc(Trc(unit, "1\t0.00\t1\t2\t3\t4\t5\t6\t\r\n2\t0.01\t 7\t8\t9\t10\t11\t12\r\n"), "a.trc");
    EXPECT_THAT(markers.names, ElementsAre("R.Heel", "L.Toe"));
    EXPECT_THAT(markers.times_s, ElementsAre(0, 0.01));
    EXPECT_LT((markers.values.col(0).head<3>() - metres * Vector3d(1, 2, 3)).norm(), 1e-12);
    EXPECT_LT((markers.values.col(1).tail<3>() - metres * Vector3d(10, 11, 12)).norm(), 1e-12);
  }
}

TEST(TrcReader, MarkersThatWereNotSeenAreLost) {
  const Readings markers = ParseTrc(Trc("m", "1\t0\t0\t0\t0\t4\t5\t6\n2\t1\t1\t2\t3\t\t\t\n3\t2\t1\t2\tNaN\t0\t0\t1\n"), "a.trc");
  EXPECT_TRUE(markers.values.col(0).head<3>().array().isNaN().all());
  EXPECT_EQ(markers.values.col(0).tail<3>(), Vector3d(4, 5, 6));
  EXPECT_EQ(markers.values.col(1).head<3>(), Vector3d(1, 2, 3));
  EXPECT_TRUE(markers.values.col(1).tail<3>().array().isNaN().all());
  EXPECT_TRUE(markers.values.col(2).head<3>().array().isNaN().all());
  EXPECT_EQ(markers.values.col(2).tail<3>(), Vector3d(0, 0, 1));
}

TEST(TrcReader, ErrorsSayWhere) {
  EXPECT_THAT(ReaderErrorOf("PathFileType\t4\n"), StartsWith("a:1: the file ends before the line of keys"));
  EXPECT_THAT(ReaderErrorOf(Trc("furlong", "")), StartsWith("a:3:14: unit must be m, cm or mm"));
  EXPECT_THAT(ReaderErrorOf(Trc("m", "")), HasSubstr("no frame"));
  EXPECT_THAT(ReaderErrorOf(Trc("m", "1\t0\t1\t2\n")), StartsWith("a:7:1: expected 8 cells, found 4"));
  EXPECT_THAT(ReaderErrorOf(Trc("m", "1\t0\t1\t2\t3\t4\t5\t6\t7\n")), StartsWith("a:7:1: expected 8 cells, found 9"));
  EXPECT_THAT(ReaderErrorOf(Trc("m", "1\t0\t1\t2\tx\t4\t5\t6\n")), StartsWith("a:7:9: not a number: x"));
  EXPECT_THAT(ReaderErrorOf(Trc("m", "1\t\t1\t2\t3\t4\t5\t6\n")), StartsWith("a:7:3: a sample must have a time"));
  std::string twice = Trc("m", "");
  twice.replace(twice.find("L.Toe"), 5, "R.Heel");
  EXPECT_THAT(ReaderErrorOf(twice), StartsWith("a:4:22: 'R.Heel' stands twice"));
  std::string wide = Trc("m", "");
  for (int i = 0; i < 600; ++i) wide.insert(wide.find("R.Heel"), "m" + std::to_string(i) + "\t\t\t");
  EXPECT_THAT(ReaderErrorOf(wide), HasSubstr("more than 500 markers"));
}

std::string Xsens(const std::string& rows) {
  return "// Start Time: Unknown\n// Update Rate: 50.0Hz\nPacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Quat_q0,Quat_q1,Quat_q2,Quat_q3\n" + rows;
}

TEST(XsensReader, KeepsAccelerationsRatesAndOrientations) {
  const SensorRecording recording = ParseXsens({{"foot", "a.txt", Xsens("7,,1,2,3,0.1,0.2,0.3,2,0,0,0\n9,,4,5,6,0.4,0.5,0.6,0,0,1,0\n")}});
  EXPECT_THAT(recording.accelerations.names, ElementsAre("foot"));
  EXPECT_THAT(recording.accelerations.times_s, ElementsAre(0, 0.04));
  EXPECT_EQ(recording.accelerations.values.col(1), Vector3d(4, 5, 6));
  EXPECT_EQ(recording.rates_rad_s.col(0), Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(recording.orientations.col(0), Eigen::Vector4d(1, 0, 0, 0));
}

TEST(XsensReader, PutsSensorsOnOneTimeLineByTheirCounters) {
  const SensorRecording recording = ParseXsens({{"a", "a.txt", Xsens("65534,,1,1,1,,,,,,,\n65535,,2,2,2,,,,,,,\n2,,3,3,3,,,,,,,\n0,,4,4,4,,,,,,,\n")},
                                                {"b", "b.txt", Xsens("65535,,5,5,5,,,,,,,\n0,,6,6,6,,,,,,,\n1,,7,7,7,,,,,,,\n")}});
  EXPECT_THAT(recording.accelerations.times_s, ElementsAre(0, 0.02, 0.04, 0.06, 0.08));
  const Eigen::MatrixXd& values = recording.accelerations.values;
  EXPECT_EQ(values(0, 0), 1);
  EXPECT_EQ(values(0, 1), 2);
  EXPECT_EQ(values(0, 2), 4);
  EXPECT_TRUE(std::isnan(values(0, 3)));
  EXPECT_EQ(values(0, 4), 3);
  EXPECT_TRUE(std::isnan(values(3, 0)));
  EXPECT_EQ(values(3, 1), 5);
  EXPECT_EQ(values(3, 3), 7);
  EXPECT_TRUE(std::isnan(values(3, 4)));
  EXPECT_TRUE(recording.rates_rad_s.array().isNaN().all());
}

TEST(XsensReader, ReadsTabsAndAnotherWayToSayTheRate) {
  const SensorRecording recording =
      ParseXsens({{"a", "a.txt", "Acquisition frequency: 100 Hz\nPacketCounter\tAcc_X\tAcc_Y\tAcc_Z\r\n3.0\t1\t2\t3\r\n5.0\t4\t5\t6\r\n"}});
  EXPECT_THAT(recording.accelerations.times_s, ElementsAre(0, 0.02));
  EXPECT_EQ(recording.accelerations.values.col(1), Vector3d(4, 5, 6));
  EXPECT_EQ(recording.rates_rad_s.rows(), 0);
  EXPECT_EQ(recording.orientations.rows(), 0);
}

TEST(XsensReader, NamesAreWhatFilesDoNotShare) {
  EXPECT_THAT(XsensNames({"Trial-1_L_Foot_00B40C55", "Trial-1_L_LowLeg_00B40BA5", "Trial-1_Pelvis_00B40B91"}), ElementsAre("L_Foot", "L_LowLeg", "Pelvis"));
  EXPECT_THAT(XsensNames({"Trial_L_Foot_00B40C55", "Trial_L_Shank_00B40BA5"}), ElementsAre("L_Foot", "L_Shank"));
  EXPECT_THAT(XsensNames({"1-1_lb", "1-1_lf", "1-1_rf"}), ElementsAre("lb", "lf", "rf"));
  EXPECT_THAT(XsensNames({"Trial_L_Foot_00B40C55"}), ElementsAre("Trial_L_Foot"));
  EXPECT_THAT(XsensNames({"walk_deadbeef"}), ElementsAre("walk_deadbeef"));
  EXPECT_THAT(XsensNames({"foot_00B40C55", "foot_00B40C56"}), ElementsAre("foot_00B40C55", "foot_00B40C56"));
}

TEST(XsensReader, ErrorsSayWhere) {
  EXPECT_THAT(ReaderErrorOf(Xsens("")), StartsWith("a:3: no sample"));
  EXPECT_THAT(ReaderErrorOf(Xsens("1,,2,3\n")), StartsWith("a:4:1: expected 12 cells, found 4"));
  EXPECT_THAT(ReaderErrorOf(Xsens("1,,2,3,x,,,,,,,\n")), StartsWith("a:4:8: not a number: x"));
  EXPECT_THAT(ReaderErrorOf(Xsens("1.5,,2,3,4,,,,,,,\n")), StartsWith("a:4:1: the packet counter must be a whole number"));
  EXPECT_THAT(ReaderErrorOf(Xsens("-1,,2,3,4,,,,,,,\n")), StartsWith("a:4:1: the packet counter must be a whole number"));
  EXPECT_THAT(ReaderErrorOf(Xsens("1,,2,3,4,,,,,,,\n999999999999,,2,3,4,,,,,,,\n")), StartsWith("a:5:1: the packet counter runs over more than a day"));
  EXPECT_THAT(ReaderErrorOf("PacketCounter,Acc_X,Acc_Y,Acc_Z\n1,2,3,4\n"), HasSubstr("no update rate"));
  EXPECT_THAT(ReaderErrorOf("// Update Rate: 0Hz\nPacketCounter,Acc_X,Acc_Y,Acc_Z\n"), StartsWith("a:1:1: the update rate must be above 0"));
  EXPECT_THAT(ReaderErrorOf("// 9Hz\nPacketCounter,Acc_X,Acc_Y\n"), StartsWith("a:2:1: the columns Acc_X, Acc_Y and Acc_Z are needed"));
  EXPECT_THROW(ParseXsens({}), DatasetError);
  EXPECT_THROW(ParseXsens({{"a", "a", Xsens("1,,2,3,4,,,,,,,\n")}, {"b", "b", Xsens("9,,2,3,4,,,,,,,\n")}}), DatasetError);
}

TEST(FootSensorReader, SortsColumnsBySensorAndAxis) {
  const std::string text =
      "sensor,left,right,left,right,left,right,left,left,left\naxis,acc_x,acc_x,acc_z,acc_z,acc_y,acc_y,gyr_x,gyr_y,gyr_z\n0,1,2,3,4,5,6,7,8,9\n2,1,2,,4,5,6,7,8,9\n";
  const SensorRecording recording = ParseFootSensors(text, "a.csv", 100);
  EXPECT_THAT(recording.accelerations.names, ElementsAre("left", "right"));
  EXPECT_THAT(recording.accelerations.times_s, ElementsAre(0, 0.02));
  EXPECT_EQ(recording.accelerations.values.col(0), (Eigen::VectorXd(6) << 1, 5, 3, 2, 6, 4).finished());
  EXPECT_TRUE(std::isnan(recording.accelerations.values(2, 1)));
  EXPECT_EQ(recording.rates_rad_s.col(0).head<3>(), Vector3d(7, 8, 9));
  EXPECT_TRUE(recording.rates_rad_s.col(0).tail<3>().array().isNaN().all());
  EXPECT_NEAR(ParseFootSensors(text, "a.csv").accelerations.times_s[1], 2 / 204.8, 1e-12);
}

TEST(FootSensorReader, ErrorsSayWhere) {
  const std::string head = "sensor,left,left,left\naxis,acc_x,acc_y,acc_z\n";
  EXPECT_THAT(ReaderErrorOf("sensor,left,left\naxis,acc_x,acc_y\n"), StartsWith("a:2:1: 'left' has no acc_z"));
  EXPECT_THAT(ReaderErrorOf("sensor,left,left\naxis,acc_x,acc_x\n"), StartsWith("a:2:12: acc_x of 'left' stands twice"));
  EXPECT_THAT(ReaderErrorOf("sensor,left\naxis,mag_x\n"), StartsWith("a:2:6: expected acc_x"));
  EXPECT_THAT(ReaderErrorOf("sensor,left\naxis,acc_x,acc_y\n"), StartsWith("a:2:1: expected 2 cells, found 3"));
  EXPECT_THAT(ReaderErrorOf(head), HasSubstr("no sample"));
  EXPECT_THAT(ReaderErrorOf(head + "0,1,2\n"), StartsWith("a:3:1: expected 4 cells, found 3"));
  EXPECT_THAT(ReaderErrorOf(head + "x,1,2,3\n"), StartsWith("a:3:1: not a number: x"));
  EXPECT_THAT(ReaderErrorOf(head + "0,1,2,y\n"), StartsWith("a:3:7: not a number: y"));
}

TEST(MarkerTable, ReadsBothKindsOfHeader) {
  const Readings one = ParseMarkerTable("frame,L_HEE_x,L_HEE_y,L_HEE_z\n0,1,2,3\n1,4,5,6\n", "a.csv", 50);
  const Readings two = ParseMarkerTable(",L_HEE,L_HEE,L_HEE\n,x,y,z\n0,1,2,3\n1,4,5,6\n", "a.csv", 50);
  for (const Readings& markers : {one, two}) {
    EXPECT_THAT(markers.names, ElementsAre("L_HEE"));
    EXPECT_THAT(markers.times_s, ElementsAre(0, 0.02));
    EXPECT_EQ(markers.values.col(1), Vector3d(4, 5, 6));
  }
}

TEST(MarkerTable, ErrorsSayWhere) {
  const std::string head = "frame,a_x,a_y,a_z\n";
  EXPECT_THAT(ReaderErrorOf("frame,a_x,a_y,a_y\n\n"), StartsWith("a:1:15: expected the column of z"));
  EXPECT_THAT(ReaderErrorOf("frame,a_x,a_y,b_z\n\n"), StartsWith("a:1:15: expected a column of 'a'"));
  EXPECT_THAT(ReaderErrorOf("frame,a_x,a_y,a_z,a_x,a_y,a_z\n\n"), StartsWith("a:1:19: 'a' stands twice"));
  EXPECT_THAT(ReaderErrorOf(head + "0,1,2\n"), StartsWith("a:2:1: expected 4 cells"));
  EXPECT_THAT(ReaderErrorOf(head + "0,1,2,z\n"), StartsWith("a:2:7: not a number: z"));
  EXPECT_THAT(ReaderErrorOf(",a,a,a\n,x,y,z\n"), HasSubstr("no frame"));
}

Readings Box(const Vector3d& size) {
  Readings markers;
  markers.names = {"a", "b"};
  markers.times_s = {0, 1};
  markers.values.resize(6, 2);
  markers.values.col(0) << Vector3d(3, 4, 5), Vector3d(3, 4, 5) + size;
  markers.values.col(1) = markers.values.col(0);
  return markers;
}

TEST(MarkerUnits, AreKnownByTheBodysSize) {
  for (const double size_m : {0.3, 1.0, 1.8, 2.4}) {
    EXPECT_EQ(MetresPerMarkerUnit(Box({0.1 * size_m, size_m, 0})), 1) << size_m;
    EXPECT_EQ(MetresPerMarkerUnit(Box(100 * Vector3d(0.1 * size_m, size_m, 0))), 0.01) << size_m;
    EXPECT_EQ(MetresPerMarkerUnit(Box(1000 * Vector3d(0.1 * size_m, size_m, 0))), 0.001) << size_m;
  }
  Readings single = Box({0, 900, 0});
  single.values.bottomRows<3>().setConstant(std::nan(""));
  EXPECT_EQ(MetresPerMarkerUnit(single), 1);
}

TEST(MarkerUnits, AndAxesTurnUpright) {
  EXPECT_EQ(UpAxisOfMarkers(Box({0.5, 1.7, 0.8}), UpAxis::kZ), UpAxis::kY);
  EXPECT_EQ(UpAxisOfMarkers(Box({0.5, 0.8, 1.7}), UpAxis::kY), UpAxis::kZ);
  EXPECT_EQ(UpAxisOfMarkers(Box({0.5, 1.6, 1.7}), UpAxis::kY), UpAxis::kY);
  EXPECT_EQ(UpAxisOfMarkers(Box({1.5, 0.2, 0.2}), UpAxis::kZ), UpAxis::kZ);
  EXPECT_EQ(MarkersInMetres(Box({1, 1, 1}), 0.5, UpAxis::kZ).values.col(0).head<3>(), Vector3d(1.5, 2.5, -2));
}

TEST(ReadReadings, KnowsFormatsByContent) {
  const testing::TemporaryFolder folder;
  const auto format = [&](const std::string& text) { return ReadReadings(folder.Write("any.bin", text)).format; };
  EXPECT_EQ(format("time,a.x,a.y,a.z\n0,1,2,3\n"), "CSV");
  EXPECT_EQ(format("\xEF\xBB\xBF" + Trc("m", "1\t0\t1\t2\t3\t4\t5\t6\n")), "TRC markers");
  EXPECT_EQ(format(Xsens("1,,2,3,4,,,,,,,\n")), "Xsens text");
  EXPECT_EQ(format("sensor,l,l,l\naxis,acc_x,acc_y,acc_z\n0,1,2,3\n"), "foot sensors");
  EXPECT_EQ(format("frame,a_x,a_y,a_z\n0,1,2,3\n"), "table of markers");
  EXPECT_THAT(ReaderErrorOf("HIERARCHY\n"), HasSubstr("is a BVH clip"));
  EXPECT_THAT(ReaderErrorOf("nonsense"), HasSubstr("the first column must be \"time\""));
  EXPECT_THROW(ReadReadings(folder.path() / "none"), DatasetError);
  EXPECT_THROW(ReadReadings(folder.path() / "none" / "none"), DatasetError);
}

TEST(ReadReadings, TakesFoldersAndBeginningsOfNames) {
  const testing::TemporaryFolder folder;
  EXPECT_THROW(ReadReadings(folder.path()), DatasetError);
  folder.Write("1-1_lf.txt", Xsens("1,,2,3,4,,,,,,,\n"));
  folder.Write("1-1_rf.txt", Xsens("1,,2,3,4,,,,,,,\n"));
  folder.Write("1-1.json", "{}");
  folder.Write("readme.txt", "hello");
  EXPECT_THAT(ReadReadings(folder.path()).readings.names, ElementsAre("lf", "rf"));
  EXPECT_THAT(ReadReadings(folder.path() / "1-1_").readings.names, ElementsAre("lf", "rf"));
  EXPECT_THROW(ReadReadings(folder.path() / "1-1.j"), DatasetError);
}

TEST(ReadReadings, ReadsTheRealFiles) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::filesystem::path data = testing::SharedData();
  const auto expect = [&](const char* file, int names, int samples, double rate_hz, ReadingsKind kind) {
    SCOPED_TRACE(file);
    const RecordedReadings recorded = ReadReadings(data / file);
    const Readings& readings = recorded.readings;
    EXPECT_EQ(readings.sensor_count(), names);
    EXPECT_EQ(readings.sample_count(), samples);
    EXPECT_NEAR(readings.rate_hz(), rate_hz, 0.01 * rate_hz);
    EXPECT_EQ(recorded.kind, kind);
    double sum = 0;
    int seen = 0;
    for (int i = 0; i < samples; ++i) {
      for (int s = 0; s < names; ++s) {
        const Vector3d value = readings.values.col(i).segment<3>(3 * s);
        if (!value.allFinite()) continue;
        sum += kind == ReadingsKind::kMarkers ? value.y() : value.norm();
        ++seen;
      }
    }
    if (kind == ReadingsKind::kAccelerations) {
      EXPECT_GT(sum / seen, 9.7);
      EXPECT_LT(sum / seen, 17);  // feet strike hard
    } else {
      EXPECT_GT(sum / seen, 0.05);
      EXPECT_LT(sum / seen, 1.2);
    }
  };
  using enum ReadingsKind;
  expect("markers/trc/rajagopal_walk.trc", 41, 238, 100, kMarkers);
  expect("markers/trc/opencap_s3_walking2.trc", 51, 136, 100, kMarkers);
  expect("markers/markerless/pose2sim_balancing_raw.trc", 21, 100, 60, kMarkers);
  expect("real_imu/neura_s02/S02-Trial-Walk-1_vicon_markers.csv", 22, 2503, 100, kMarkers);
  expect("real_imu/gaitmap_healthy/mocap_sample.csv", 6, 3870, 100, kMarkers);
  expect("real_imu/neura_s02/imu_raw", 9, 2503, 100, kAccelerations);
  expect("real_imu/neura_s02/imu_raw/S02-Trial-Walk-1_L_Foot_00B40C55.txt", 1, 2503, 100, kAccelerations);
  expect("real_imu/gaitmap_healthy/imu_sample.csv", 2, 7928, 204.8, kAccelerations);
  expect("real_imu/ipol_gait/1-4", 3, 2849, 100, kAccelerations);
  EXPECT_THAT(ReadReadings(data / "real_imu/ipol_gait/7-1").readings.names, ElementsAre("lb", "lf", "rf"));
}

}  // namespace
}  // namespace morphograph
