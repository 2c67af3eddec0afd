#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "datasets/augmentation.h"
#include "datasets/dataset_loader.h"
#include "datasets/sensor_alignment.h"
#include "datasets/stream_repair.h"
#include "graph/graph_builder.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/readings_reconstruction.h"
#include "tests/benchmarks/leg_poses.h"
#include "tests/benchmarks/real_sensors.h"
#include "tests/benchmarks/segment_anatomy.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using Eigen::Matrix3Xd;

constexpr const char* kUsedSensors[] = {"L_Foot", "R_Foot", "L_LowLeg", "R_LowLeg", "Pelvis"};

const char* const kJointCentres[] = {"LHJC", "RHJC", "LKJC", "RKJC", "LAJC", "RAJC"};

std::shared_ptr<const MotionGraph> Train(const std::filesystem::path& bnr) {
  std::vector<MotionClip> clips;
  for (const LoadedClip& loaded : LoadDataset({bnr / "walk", bnr / "walk-turn-left", bnr / "walk-turn-right"}).clips) clips.push_back(loaded.clip);
  std::vector<TrainingClip> training;
  for (AugmentedClip& level : Augment(clips, {})) {
    if (!level.made) training.push_back({std::move(level.clip), false, static_cast<int>(training.size())});
  }
  TrainingOptions options;
  options.keep_recordings = true;
  options.jobs = 2;
  return BuildGraph(training, options);
}

Readings Part(const Readings& readings, double from_s, double to_s) {
  const auto first = static_cast<Eigen::Index>(std::lround(from_s * kReconstructionRate_hz));
  const auto last = std::min<Eigen::Index>(std::lround(to_s * kReconstructionRate_hz), readings.sample_count() - 1);
  Readings part = readings;
  part.values = readings.values.middleCols(first, last - first + 1).eval();
  part.times_s.assign(readings.times_s.begin() + first, readings.times_s.begin() + last + 1);
  return part;
}

// The whole recording, its standing included, with sensors that are told to sit otherwise than they do, by some degrees about a random axis each: as told, and aligned by standing.
void PrintAligned(const std::shared_ptr<const MotionGraph>& graph, const Readings& real, const std::vector<Placement>& placements, const std::vector<LegPlaces>& walking, double walk_from_s,
                  double length_m) {
  for (const double askew_deg : {0.0, 20.0, 30.0}) {
    std::mt19937_64 rng(5);
    std::vector<Placement> told = placements;
    for (Placement& placement : told)
      placement.joint_from_sensor = placement.joint_from_sensor * Eigen::Quaterniond(Eigen::AngleAxisd(askew_deg * M_PI / 180, testing::RandomRotation(rng) * Eigen::Vector3d::UnitX()));
    for (const ReconstructionMethod method : {ReconstructionMethod::kOlng, ReconstructionMethod::kGraph}) {
      const auto reconstructor = MakeReconstructor(graph, method, told, 2);
      for (const bool align : {false, true}) {
        ReconstructionRequest request;
        request.method = method;
        request.readings = real;
        request.placements = told;
        if (align) request.alignment.emplace();
        const ReconstructedReadings made = ReconstructReadings(*graph, request, [&](const std::vector<Placement>&) { return reconstructor; });
        const std::vector<LegPlaces> found = PlacesOfLegs(made.reconstruction.clip, length_m);
        const auto first = found.begin() + std::lround(walk_from_s * kReconstructionRate_hz);
        char name[80];
        std::snprintf(name, sizeof name, "walking, told %.0f degrees askew: %s%s", askew_deg, std::string(MethodName(method)).c_str(), align ? ", aligned" : "");
        PrintErrors(name, std::vector<LegPlaces>(first, std::min(found.end(), first + static_cast<std::ptrdiff_t>(walking.size()))), walking);
      }
    }
  }
}

}  // namespace

void PrintPoses(const std::filesystem::path& data, const NeuraRecording& neura) {
  const std::shared_ptr<const MotionGraph> graph = Train(data / "bnr/dataset-2");
  const MotionSource source = SourceOf(*graph, 2);

  StreamRepairOptions at_rate;
  at_rate.rate_hz = kReconstructionRate_hz;
  at_rate.kind = ReadingsKind::kMarkers;
  const Readings markers = RepairStream(neura.markers, at_rate).readings;
  double length_m = 0;
  std::vector<LegPlaces> truth;
  for (const bool measure : {true, false}) {
    for (int i = 0; i < markers.sample_count(); ++i) {
      LegJoints joints;
      for (int j = 0; j < 6; ++j) joints.col(j) = markers.values.col(i).segment<3>(RowOf(markers, kJointCentres[j]));
      if (measure) length_m += LegLength(joints) / markers.sample_count();
      else truth.push_back(PlacesOfLegs(joints, length_m));
    }
  }

  // What was read, what perfect sensors in the same places would have read, and where these are on the model's body.
  Readings real, simulated;
  const int samples = neura.sensors.sample_count();
  real.values.resize(3 * static_cast<Eigen::Index>(std::size(kUsedSensors)), samples);
  simulated.values = real.values;
  std::vector<Placement> placements;
  const WorldPose model_pose = ForwardKinematics(source.clips.front(), 0);
  LegJoints model_legs;
  for (int j = 0; j < 6; ++j) model_legs.col(j) = model_pose.positions.col(graph->skeleton().roles()[kLegRoles[j]]);
  const double scale = LegLength(model_legs) / length_m;
  for (const char* name : kUsedSensors) {
    const BodySensor& sensor = *std::find_if(BodySensors().begin(), BodySensors().end(), [&](const BodySensor& s) { return s.name == std::string(name); });
    const auto row = 3 * static_cast<Eigen::Index>(placements.size());
    const SegmentMotion segment = SegmentFromMarkers(neura.markers, sensor.markers);
    const Matrix3Xd readings = neura.sensors.values.middleRows<3>(RowOf(neura.sensors, sensor.name));
    const SensorAlignment alignment = AlignSensor(segment, readings);
    const int delay = std::max(0, alignment.delay_samples);
    real.values.middleRows<3>(row) << readings.rightCols(samples - delay), readings.rightCols(1).replicate(1, delay);
    simulated.values.middleRows<3>(row) = ReadingsOf(segment, alignment, 15);
    placements.push_back(PlacementOf(sensor, alignment, AnatomyOf(sensor, neura, segment), AnatomyOf(sensor.joint, source.clips), scale));
    real.names.emplace_back(sensor.name);
    std::printf("    %-10s on the model: offset %5.2f %5.2f %5.2f m\n", name, placements.back().offset_m.x(), placements.back().offset_m.y(), placements.back().offset_m.z());
  }
  real.times_s = neura.sensors.times_s;
  simulated.names = real.names;
  simulated.times_s = real.times_s;
  at_rate.kind = ReadingsKind::kAccelerations;
  const Readings real_30 = RepairStream(real, at_rate).readings, simulated_30 = RepairStream(simulated, at_rate).readings;

  std::printf("\nPoses from 5 sensors (feet, shanks, pelvis), model: bnr walks and turns. Knees and ankles against the marker joint centres, seen from the middle of the hips, legs of %.2f m (model: %.2f)\n"
              "  %-56s %6s %6s %10s %6s\n", length_m, LegLength(model_legs), "", "cm", "95 %", "moving cm", "95 %");
  const double walk_from_s = neura.walk_first / 100.0, walk_to_s = neura.walk_last / 100.0;
  const auto part_of = [&](double from_s, double to_s) {
    const auto first = std::lround(from_s * kReconstructionRate_hz), last = std::min<long>(std::lround(to_s * kReconstructionRate_hz), static_cast<long>(truth.size()) - 1);
    return std::vector<LegPlaces>(truth.begin() + first, truth.begin() + last + 1);
  };
  struct Span {
    const char* name;
    double from_s, to_s;
  };
  double first_strike_s = walk_to_s, last_strike_s = walk_from_s;
  for (const auto& [label, times] : neura.strikes_s) {
    if (!label.ends_with("strike")) continue;  // else where the person stands
    for (const double time : times) first_strike_s = std::min(first_strike_s, time), last_strike_s = std::max(last_strike_s, time);
  }
  const Span spans[] = {{"first to last strike", first_strike_s, last_strike_s}, {"walking", walk_from_s, walk_to_s}, {"whole, with 15 s of standing", 0, 1e3}};
  for (const Span& span : spans) {
    const std::vector<LegPlaces> there = part_of(span.from_s, span.to_s);
    PrintErrors(std::string(span.name) + ": the person's own mean pose", std::vector<LegPlaces>(there.size(), MeanOf(there)), there);
    PrintErrors(std::string(span.name) + ": the model's nearest pose (a bound)", NearestPoses(source.clips, there, length_m), there);
    for (const ReconstructionMethod method : {ReconstructionMethod::kOlng, ReconstructionMethod::kGraph}) {
      const auto reconstructor = MakeReconstructor(graph, method, placements, 2);
      for (const auto& [name, readings] : {std::pair<const char*, const Readings*>{"real sensors", &real_30}, {"simulated sensors", &simulated_30}}) {
        const Reconstruction made = reconstructor->Run(Part(*readings, span.from_s, span.to_s).values);
        PrintErrors(std::string(span.name) + ": " + std::string(MethodName(method)) + ", " + name, PlacesOfLegs(made.clip, length_m), there);
      }
    }
  }
  PrintAligned(graph, real, placements, part_of(walk_from_s, walk_to_s), walk_from_s, length_m);
}

}  // namespace morphograph
