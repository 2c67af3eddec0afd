// The verbs `sensors` and `markers`: what sensors or markers on a body would say of a clip.
#include <iostream>
#include <memory>

#include "api/cli/command.h"
#include "api/cli/staged_files.h"
#include "api/clip_request.h"
#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/marker_set.h"
#include "datasets/resample.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/marker_selection.h"
#include "synthesis/sensors/marker_tracks.h"
#include "synthesis/sensors/motion_base.h"

namespace morphograph {
namespace {

struct VirtualFlags {
  std::string clip, placements, out, seed = "1", write_placements;
  double rate_hz = 0;
  SensorFaults faults;
  double mounting_deg = 0;
  int principal = 0;
};

void AddFaultFlags(CLI::App* verb, VirtualFlags* flags, const char* unit) {
  const std::string in_unit = std::string(", ") + unit;
  verb->add_option("--noise", flags->faults.noise, "White noise on every value, standard deviation" + in_unit)->check(CLI::Range(0.0, 1e9));
  verb->add_option("--bias", flags->faults.bias, "Constant error of every axis, standard deviation" + in_unit)->check(CLI::Range(0.0, 1e9));
  verb->add_option("--loss", flags->faults.loss, "Chance that a sample of a sensor is lost")->check(CLI::Range(0.0, 0.99));
  verb->add_option("--seed", flags->seed, "Of these faults; 64-bit unsigned integer")->capture_default_str();
}

Readings WithFaultsOf(const VirtualFlags& flags, const Readings& readings) {
  SensorFaults faults = flags.faults;
  faults.mounting_rad = flags.mounting_deg * M_PI / 180;
  const std::optional<std::uint64_t> seed = ParseSeed(flags.seed);
  if (!seed) throw UsageError("--seed: '" + flags.seed + "' is not an integer from 0 to 18446744073709551615");
  const bool sound = faults.noise == 0 && faults.bias == 0 && faults.loss == 0 && faults.range == 0 && faults.mounting_rad == 0;
  return sound ? readings : WithFaults(readings, faults, *seed);
}

void WriteReadings(const VirtualFlags& flags, const Readings& readings, const std::vector<Placement>& placements) {
  StagedFiles files;
  files.Add(flags.out, ReadingsCsv(readings));
  if (!flags.write_placements.empty()) files.Add(flags.write_placements, PlacementsJson(placements));
  files.Commit();
  std::cout << "wrote " << flags.out << ", " << readings.sensor_count() << (readings.sensor_count() == 1 ? " sensor, " : " sensors, ")
            << readings.sample_count() << " samples\n";
}

MotionClip ReadClip(const VirtualFlags& flags) { return ImportClip(ReadBvhFile(flags.clip)); }

// Joints that do not exist are the placements' fault, the rest the clip's.
template <typename Work>
auto OfClip(const VirtualFlags& flags, const MotionClip& clip, const std::vector<Placement>& placements, const Work& work) {
  try {
    JointsOf(placements, clip.skeleton());
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(flags.placements.empty() ? flags.clip : flags.placements, unfit.what());
  }
  try {
    return work();
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(flags.clip, ReasonOf(unfit));
  }
}

void MakeSensors(const VirtualFlags& flags) {
  const std::vector<Placement> placements = ReadPlacements(flags.placements);
  const MotionClip clip = ReadClip(flags);
  const Readings readings = OfClip(flags, clip, placements, [&] { return VirtualAccelerations(clip, placements, flags.rate_hz); });
  WriteReadings(flags, WithFaultsOf(flags, readings), placements);
}

// Of these the few that say most of the others (Liu 3.1.1), as they move in the clip and its mirror image.
std::vector<Placement> PrincipalOf(const VirtualFlags& flags, const MotionClip& clip, const std::vector<Placement>& placements) {
  const MotionBase base({clip}, {}, {});
  MarkerSelectionOptions options;
  options.count = flags.principal;
  std::vector<Placement> chosen;
  for (const int m : PrincipalMarkers(MarkerTracks(base, placements), options)) chosen.push_back(placements[static_cast<std::size_t>(m)]);
  return chosen;
}

void MakeMarkers(const VirtualFlags& flags) {
  MotionClip clip = ReadClip(flags);
  std::vector<Placement> placements;
  if (!flags.placements.empty()) {
    placements = ReadPlacements(flags.placements);
  } else {
    placements = OfClip(flags, clip, {}, [&] { return FullBodyMarkers({clip}); });
  }
  if (flags.principal > 0) placements = OfClip(flags, clip, placements, [&] { return PrincipalOf(flags, clip, placements); });
  const Readings readings = OfClip(flags, clip, placements, [&] {
    if (flags.rate_hz > 0) clip = Resample(clip, flags.rate_hz);
    return VirtualMarkers(clip, placements);
  });
  WriteReadings(flags, WithFaultsOf(flags, readings), placements);
}

}  // namespace

void AddSensors(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<VirtualFlags>();
  CLI::App* verb = program->add_subcommand("sensors", "Tell what accelerometers on the body would read during a clip");
  verb->add_option("clip", flags->clip, "BVH file")->required();
  verb->add_option("--placements", flags->placements, "Where the sensors sit, JSON: [{\"joint\": \"left_wrist\", \"offset\": [x, y, z]}]")->required();
  verb->add_option("--rate", flags->rate_hz, "Samples a second")->required()->check(CLI::Range(1.0, 2000.0));
  verb->add_option("--out", flags->out, "CSV file to write")->required();
  AddFaultFlags(verb, flags.get(), "m/s^2");
  verb->add_option("--mounting", flags->mounting_deg, "Sensors sit askew: standard deviation of the angle, degrees")->check(CLI::Range(0.0, 1e9));
  verb->add_option("--range", flags->faults.range, "Values are clipped at plus and minus this, m/s^2; 0: not")->check(CLI::Range(0.0, 1e9));
  verb->callback([flags, work] { *work = [flags] { MakeSensors(*flags); }; });
}

void AddMarkers(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<VirtualFlags>();
  CLI::App* verb = program->add_subcommand("markers", "Tell where markers on the body would be seen during a clip");
  verb->add_option("clip", flags->clip, "BVH file")->required();
  verb->add_option("--placements", flags->placements, "Where the markers sit, JSON; a usual set of 41 when absent");
  verb->add_option("--rate", flags->rate_hz, "Samples a second; the clip's own when absent")->check(CLI::Range(1.0, 2000.0));
  verb->add_option("--out", flags->out, "CSV file to write")->required();
  verb->add_option("--principal", flags->principal, "Only so many, those that say most of the others")->check(CLI::Range(1, 500));
  verb->add_option("--write-placements", flags->write_placements, "File for the placements that were used, JSON");
  AddFaultFlags(verb, flags.get(), "m");
  verb->callback([flags, work] { *work = [flags] { MakeMarkers(*flags); }; });
}

}  // namespace morphograph
