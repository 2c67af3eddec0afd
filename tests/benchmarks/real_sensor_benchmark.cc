// What real sensors and markers give: how well they fit the body's motion, the steps found by them, and poses reconstructed from them beside those from simulated sensors.
//
//   real_sensor_benchmark --data DIR [--no-poses]
//
// DIR holds real_imu/, markers/, keyframes/ and bnr/. Residuals are root mean square lengths over the walking part, both sides under a 10 Hz low-pass. Step times are those of the sensor's own clock.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "datasets/foot_strikes.h"
#include "datasets/quantile.h"
#include "datasets/readings_reader.h"
#include "datasets/sensor_alignment.h"
#include "datasets/stream_repair.h"
#include "tests/benchmarks/real_sensors.h"

namespace morphograph {

const std::vector<BodySensor>& BodySensors() {
  static const std::vector<BodySensor> sensors = {
      {"L_Foot", {"LANK", "LHEE", "LTOE", "LAJC"}, "left_ankle", 2.3},
      {"R_Foot", {"RANK", "RHEE", "RTOE", "RAJC"}, "right_ankle", 2.3},
      {"L_LowLeg", {"LKNE", "LTIB", "LANK"}, "left_knee", 2.3},
      {"R_LowLeg", {"RKNE", "RTIB", "RANK"}, "right_knee", 2.3},
      {"L_LowLeg2", {"LKNE", "LTIB", "LANK"}, "left_knee", 2.3},
      {"R_LowLeg2", {"RKNE", "RTIB", "RANK"}, "right_knee", 2.3},
      {"L_UpLeg", {"LHJC", "LTHI", "LKNE"}, "left_hip", 0},
      {"R_UpLeg", {"RHJC", "RTHI", "RKNE"}, "right_hip", 0},
      {"Pelvis", {"LASI", "RASI", "LPSI", "RPSI"}, "hips", 0},
  };
  return sensors;
}

Eigen::Index RowOf(const Readings& readings, const std::string& name) {
  const auto found = std::find(readings.names.begin(), readings.names.end(), name);
  if (found == readings.names.end()) throw std::runtime_error("there is no '" + name + "'");
  return 3 * (found - readings.names.begin());
}

namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using nlohmann::json;

constexpr double kTolerance_s = 0.06;
constexpr double kSameStep_s = 0.25;

json ReadJson(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  // Some of the recordings' descriptions hold a bare NaN where a weight is not known, which is no JSON.
  for (std::size_t at; (at = text.find("NaN")) != std::string::npos;) text.replace(at, 3, "null");
  return json::parse(text);
}

Readings Repaired(const std::filesystem::path& path, double rate_hz = 0) {
  const RecordedReadings recorded = ReadReadings(path);
  StreamRepairOptions options;
  options.rate_hz = rate_hz;
  options.kind = recorded.kind.value_or(ReadingsKind::kAccelerations);
  return RepairStream(recorded.readings, options, path.string()).readings;
}

// ---- the sensors of neura_s02 ----

NeuraRecording ReadNeura(const std::filesystem::path& data) {
  NeuraRecording neura;
  neura.sensors = Repaired(data / "real_imu/neura_s02/imu_raw");
  neura.markers = Repaired(data / "real_imu/neura_s02/S02-Trial-Walk-1_vicon_markers.csv");
  const json clips = ReadJson(data / "keyframes/neura_s02_keyframes.json");
  for (const json& key : clips.front()) {
    const int frame = key.at("frame");
    const std::string label = key.at("label");
    if (label == "stand_end" && neura.walk_first == 0) neura.walk_first = frame;
    if (label == "stand_begin") neura.walk_last = frame;
    (key.value("doubtful", false) ? neura.doubtful_s : neura.strikes_s)[label].push_back(frame / 100.0);
  }
  return neura;
}

void PrintAlignment(const NeuraRecording& neura) {
  std::printf("Sensors against markers, neura_s02, walking (samples %d to %d): aims are <= 2.3 m/s^2 and >= 0.82 on feet and shanks\n", neura.walk_first, neura.walk_last);
  std::printf("  %-10s %8s %12s %12s %12s   %s\n", "sensor", "delay", "residual", "correlation", "whole clip", "lever arm, m");
  for (const BodySensor& sensor : BodySensors()) {
    const SegmentMotion segment = SegmentFromMarkers(neura.markers, sensor.markers);
    const Matrix3Xd readings = neura.sensors.values.middleRows<3>(RowOf(neura.sensors, sensor.name));
    const SensorAlignment alignment = AlignSensor(segment, readings);
    const AlignmentQuality walking = MeasureAlignment(segment, readings, alignment, neura.walk_first, neura.walk_last);
    const AlignmentQuality whole = MeasureAlignment(segment, readings, alignment, 5, segment.sample_count() - 10);
    std::printf("  %-10s %8d %7.2f m/s^2 %12.3f %7.2f m/s^2 %6.2f %6.2f %6.2f%s\n", sensor.name, alignment.delay_samples, walking.residual_m_s2, walking.correlation, whole.residual_m_s2,
                alignment.offset_m.x(), alignment.offset_m.y(), alignment.offset_m.z(),
                sensor.aim_m_s2 == 0 ? "" : walking.residual_m_s2 <= sensor.aim_m_s2 && walking.correlation >= 0.82 ? "   met" : "   missed");
  }
}

// ---- steps ----

struct StepScore {
  int labels = 0, found = 0, near = 0, extra = 0;
  std::vector<double> errors_s;

  void Add(const std::vector<double>& labelled_s, const std::vector<double>& found_s, double from_s, double to_s) {
    std::set<std::size_t> used;
    for (const double label : labelled_s) {
      ++labels;
      std::size_t nearest = 0;
      for (std::size_t i = 0; i < found_s.size(); ++i) {
        if (std::abs(found_s[i] - label) < std::abs(found_s[nearest] - label)) nearest = i;
      }
      if (found_s.empty() || std::abs(found_s[nearest] - label) > kSameStep_s) continue;
      used.insert(nearest);
      ++found;
      errors_s.push_back(found_s[nearest] - label);
      near += std::abs(errors_s.back()) <= kTolerance_s + 1e-9;
    }
    for (std::size_t i = 0; i < found_s.size(); ++i) extra += !used.count(i) && found_s[i] >= from_s && found_s[i] <= to_s;
  }

  void Print(const char* name) const {
    if (errors_s.empty()) {
      std::printf("  %-28s %4d labels, none found\n", name, labels);
      return;
    }
    std::printf("  %-28s %4d labels, %4d found, %4d within 60 ms (%.0f %%), %d more between the first and the last; median %+.0f ms, 5 %% .. 95 %% %+.0f .. %+.0f ms\n", name, labels, found, near,
                100.0 * near / labels, extra, 1000 * Median(errors_s), 1000 * Quantile(errors_s, 0.05), 1000 * Quantile(errors_s, 0.95));
  }
};

std::vector<double> StrikesOf(const Readings& readings, const std::string& name) {
  return FootStrikeTimes(readings.values.middleRows<3>(RowOf(readings, name)), readings.rate_hz());
}

void AddSpan(const std::vector<double>& labels, const std::vector<double>& found, StepScore* score) {
  if (labels.empty()) return;
  const auto [first, last] = std::minmax_element(labels.begin(), labels.end());
  score->Add(labels, found, *first - kSameStep_s, *last + kSameStep_s);
}

void PrintSteps(const std::filesystem::path& data, const NeuraRecording& neura) {
  std::printf("\nStep times by the sensor on the foot\n");
  StepScore sure, doubtful;
  for (const auto& [sensor, label] : {std::pair<std::string, std::string>{"L_Foot", "left_strike"}, {"R_Foot", "right_strike"}}) {
    const std::vector<double> found = StrikesOf(neura.sensors, sensor);
    const auto labels = neura.strikes_s.find(label), unsure = neura.doubtful_s.find(label);
    if (unsure != neura.doubtful_s.end()) doubtful.Add(unsure->second, found, 1, 0);
    if (labels == neura.strikes_s.end()) continue;
    AddSpan(labels->second, found, &sure);
    for (const double strike : labels->second) {
      double error = 1e9;
      for (const double time : found) error = std::abs(time - strike) < std::abs(error) ? time - strike : error;
      if (std::abs(error) > kTolerance_s + 1e-9) std::printf("    %s at %.2f s is found %+.0f ms off\n", label.c_str(), strike, 1000 * error);
    }
  }
  sure.Print("neura_s02, sure labels");
  doubtful.Print("neura_s02, doubtful labels");

  StepScore all;
  for (const char* trial : {"1-1", "1-4", "2-1", "3-2", "5-1", "7-1"}) {
    const std::filesystem::path path = data / "real_imu/ipol_gait" / trial;
    const Readings readings = Repaired(path.string() + "_");
    const json events = ReadJson(path.string() + ".json");
    StepScore score;
    for (const auto& [sensor, key] : {std::pair<std::string, std::string>{"lf", "LeftFootEvents"}, {"rf", "RightFootEvents"}}) {
      std::vector<double> labels;
      for (const json& swing : events.at(key)) labels.push_back(swing.at(1).get<double>() / 100);
      const std::vector<double> found = StrikesOf(readings, sensor);
      AddSpan(labels, found, &score);
      AddSpan(labels, found, &all);
    }
    score.Print((std::string("ipol_gait ") + trial).c_str());
  }
  all.Print("ipol_gait, all");

  const std::filesystem::path gaitmap = data / "real_imu/gaitmap_healthy";
  const Readings feet = Repaired(gaitmap / "imu_sample.csv");
  std::map<std::string, std::set<double>> contacts;
  std::ifstream file(gaitmap / "stride_events_sample.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::stringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    if (row.size() < 8) continue;
    contacts[row[1]].insert(std::stod(row[4]) / 204.8);  // ic
    contacts[row[1]].insert(std::stod(row[7]) / 204.8);  // pre_ic
  }
  StepScore score;
  for (const auto& [foot, times] : contacts) AddSpan({times.begin(), times.end()}, StrikesOf(feet, foot + "_sensor"), &score);
  score.Print("gaitmap, initial contacts");
}

// ---- markers ----

void PrintMarkers(const std::filesystem::path& data) {
  std::printf("\nMarker files\n");
  for (const char* folder : {"markers/trc", "markers/markerless"}) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(data / folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const std::filesystem::path& path : files) {
      const RecordedReadings recorded = ReadReadings(path);
      StreamRepairOptions options;
      options.kind = ReadingsKind::kMarkers;
      const RepairedReadings repaired = RepairStream(recorded.readings, options, path.string());
      double top = 0;
      for (int m = 0; m < repaired.readings.sensor_count(); ++m) top = std::max(top, repaired.readings.values.row(3 * m + 1).mean());
      std::printf("  %-36s %2d markers, %3d frames, %.0f Hz, highest at %.2f m, lost %.1f %%, left out %zu\n", path.filename().c_str(), repaired.readings.sensor_count(), repaired.readings.sample_count(),
                  repaired.rate_hz, top, 100 * repaired.lost_share, repaired.dead_sensors.size());
    }
  }
}

}  // namespace
}  // namespace morphograph

int main(int argc, char** argv) {
  CLI::App app("Real sensors and markers: fit, steps, poses.");
  std::filesystem::path data;
  bool no_poses = false;
  app.add_option("--data", data, "folder of the recordings")->required();
  app.add_flag("--no-poses", no_poses, "leave the reconstruction out");
  CLI11_PARSE(app, argc, argv);
  try {
    const morphograph::NeuraRecording neura = morphograph::ReadNeura(data);
    morphograph::PrintAlignment(neura);
    morphograph::PrintSteps(data, neura);
    morphograph::PrintMarkers(data);
    if (!no_poses) morphograph::PrintPoses(data, neura);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
