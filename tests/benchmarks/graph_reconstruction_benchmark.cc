// The graph method of reconstruction: how near it comes to the truth, and what a frame costs (one thread).
//
//   graph_reconstruction_benchmark --data bnr/walk bnr/walk-turn-left bnr/walk-turn-right             test clips out of the model, their styles in it
//   graph_reconstruction_benchmark --data … --split style                                            and without their style
//   graph_reconstruction_benchmark --data cmu/07 cmu/08 --split folder                               without the folder that they are from (a person)
//
// A model is trained as `train` does it, on all but the left-out clips, and keeps its recordings. Of every folder and style the clip in the middle (of n, number n/2 by name) is a
// test clip; with --split folder all clips are; with --tune number n/4, on which constants are chosen. Sensors at wrists and ankles are simulated on the test clip, as it is and worse: with noise of 1.2 m/s^2 and sensors askew by
// 10 degrees, played slower and faster by a fifth, and by a body of 0.8 and 1.2 times the size.
//
// Error: root mean square distance of the joints in the pelvis frame, cm, a value a frame; mean and 95th percentile over all frames. Skate: times the truth's. Feet: share of
// frames that agree on standing. ln p: of a step on the graph. Lower is better but for jerk and skate, best at 1, and feet.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "datasets/augmentation.h"
#include "datasets/dataset_loader.h"
#include "datasets/quantile.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "datasets/virtual_sensors.h"
#include "graph/graph_builder.h"
#include "synthesis/control/sensor_guide.h"
#include "synthesis/evaluation.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/sensors/reconstruction.h"
#include "tests/support/body_size.h"

namespace {

using namespace morphograph;

struct Recorded {
  MotionClip clip;
  std::string folder;
  bool test = false;
  bool out = false;   // of every model
  std::string group;  // left out together with all of this group
};

std::vector<Recorded> Load(const std::vector<std::filesystem::path>& folders, const std::string& split, bool tune) {
  const Dataset dataset = LoadDataset(folders);
  std::vector<MotionClip> clips;
  for (const LoadedClip& loaded : dataset.clips) clips.push_back(loaded.clip);
  std::vector<Recorded> recorded;
  for (AugmentedClip& level : Augment(clips, {})) {
    if (!level.made) recorded.push_back({std::move(level.clip), dataset.clips[recorded.size()].file.parent_path().filename().string(), false, false, {}});
  }
  std::map<std::pair<std::string, std::string>, std::vector<std::size_t>> kinds;
  for (std::size_t i = 0; i < recorded.size(); ++i) kinds[{recorded[i].folder, recorded[i].clip.style}].push_back(i);
  for (const auto& [kind, members] : kinds) {
    recorded[members[members.size() / 2]].out = true;
    recorded[members[members.size() / (tune ? 4 : 2)]].test = true;
  }
  for (Recorded& clip : recorded) {
    if (split == "folder") clip.test = true;
    clip.group = split == "folder" ? clip.folder : split == "style" ? clip.clip.style : "test clips";
  }
  return recorded;
}

std::shared_ptr<const MotionGraph> TrainWithout(const std::vector<Recorded>& recorded, const std::string& group, const std::string& split) {
  std::vector<TrainingClip> clips;
  for (const Recorded& clip : recorded) {
    if (split == "clip" ? !clip.test && !clip.out : clip.group != group) clips.push_back({clip.clip, false, static_cast<int>(clips.size())});
  }
  TrainingOptions options;
  options.keep_recordings = true;
  options.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return BuildGraph(clips, options);
}

struct Row {
  std::vector<double> errors_cm;
  double jerk = 0, skate = 0, feet = 0, likelihood = 0, time_ms = 0;  // sums, weighted by frames
  int clips = 0;
};

void Add(const Reconstructor& reconstructor, const MotionClip& worn, const MotionClip& truth, const SensorFaults& faults, Row* row) {
  Readings readings = VirtualAccelerations(worn, reconstructor.sensors(), kReconstructionRate_hz);
  readings = WithFaults(readings, faults, 1);
  const Reconstruction made = reconstructor.Run(readings.values);
  MotionClip there = truth;
  if (there.shared_skeleton() != made.clip.shared_skeleton()) there = Retarget(there, made.clip.shared_skeleton());
  const ReconstructionQuality quality = CompareClips(made.clip, there);
  const double frames = quality.frames;
  row->errors_cm.insert(row->errors_cm.end(), quality.frame_rms_cm.begin(), quality.frame_rms_cm.end());
  row->jerk += frames * quality.jerk_ratio;
  row->skate += frames * made.report.quality.foot_skate_cm_s / EvaluateClip(there).quality.foot_skate_cm_s;
  row->feet += frames * quality.contact_agreement;
  row->likelihood += frames * *made.report.quality.log_likelihood / static_cast<double>(made.report.steps.size());
  row->time_ms += frames * made.latency_ms_mean;
  ++row->clips;
}

// The same readings as a clip request: the walk is optimised over the graph's latents (SensorResidual), not fitted step by step.
void AddSteered(const std::shared_ptr<const MotionGraph>& graph, const Reconstructor& reconstructor, const MotionClip& truth, const SensorFaults& faults, Row* row) {
  SynthesisRequest request;
  SensorTerm& term = request.control.sensors.emplace();
  term.placements = reconstructor.sensors();
  term.readings = WithFaults(VirtualAccelerations(truth, reconstructor.sensors(), kReconstructionRate_hz), faults, 1);
  const std::clock_t started = std::clock();
  PrepareSensors(*graph, &request, [&](const std::vector<Placement>&) { return reconstructor.steps(); });
  const SynthesisResult made = Synthesize(*graph, request);
  const double ms = 1e3 * static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC;
  const ReconstructionQuality quality = CompareClips(made.clip, truth);
  const double frames = quality.frames;
  row->errors_cm.insert(row->errors_cm.end(), quality.frame_rms_cm.begin(), quality.frame_rms_cm.end());
  row->jerk += frames * quality.jerk_ratio;
  row->skate += frames * made.report.quality.foot_skate_cm_s / EvaluateClip(truth).quality.foot_skate_cm_s;
  row->feet += frames * quality.contact_agreement;
  row->likelihood += frames * *made.report.quality.log_likelihood / static_cast<double>(made.report.steps.size());
  row->time_ms += ms;
  ++row->clips;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Measures the graph method of reconstruction.");
  std::vector<std::filesystem::path> data;
  std::string split = "clip";
  bool plain = false, tune = false;
  program.add_option("--data", data, "Folders of BVH")->required();
  program.add_option("--split", split, "clip, style or folder")->check(CLI::IsMember({"clip", "style", "folder"}));
  program.add_flag("--plain", plain, "Without faults, tempos and sizes");
  program.add_flag("--tune", tune, "The clips on which constants are chosen: number n/4 of every folder and style");
  CLI11_PARSE(program, argc, argv);

  const std::vector<Recorded> recorded = Load(data, split, tune);
  std::set<std::string> groups;
  for (const Recorded& clip : recorded) groups.insert(clip.group);
  const std::vector<Placement> sensors = PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"});
  std::vector<std::string> order;
  std::map<std::string, Row> rows;
  const auto row = [&](const std::string& name) {
    if (!rows.contains(name)) order.push_back(name);
    return &rows[name];
  };
  for (const std::string& group : groups) {
    const std::shared_ptr<const MotionGraph> graph = TrainWithout(recorded, group, split);
    const auto reconstructor = MakeReconstructor(graph, ReconstructionMethod::kGraph, sensors, 2);
    for (const Recorded& clip : recorded) {
      if (!clip.test || clip.group != group || clip.clip.duration_s() < 1) continue;
      const MotionClip& truth = clip.clip;
      Add(*reconstructor, truth, truth, {}, row("as captured"));
      AddSteered(graph, *reconstructor, truth, {}, row("steered clip"));
      if (split != "clip") Add(*reconstructor, truth, truth, {}, row("  " + (split == "style" ? truth.style : clip.folder)));
      if (plain) continue;
      AddSteered(graph, *reconstructor, truth, {.noise = 1.2, .mounting_rad = 10 * M_PI / 180}, row("steered, noise, askew"));
      Add(*reconstructor, truth, truth, {.noise = 1.2, .mounting_rad = 10 * M_PI / 180}, row("noise and askew"));
      for (const double tempo : {0.8, 1.2}) {
        const MotionClip played = Resample(Retimed(truth, truth.frame_rate_hz() * tempo), kReconstructionRate_hz);
        Add(*reconstructor, played, played, {}, row(tempo < 1 ? "a fifth slower" : "a fifth faster"));
      }
      for (const double scale : {0.8, 1.2}) Add(*reconstructor, testing::OfSize(truth, scale), truth, {}, row(scale < 1 ? "0.8 times the size" : "1.2 times the size"));
    }
  }
  std::printf("%-22s %6s %8s %8s %6s %6s %6s %8s %9s\n", "", "clips", "mean cm", "95 % cm", "jerk", "skate", "feet", "ln p", "ms/frame");
  for (const std::string& name : order) {
    const Row& r = rows[name];
    const double frames = static_cast<double>(r.errors_cm.size());
    double mean = 0;
    for (const double error : r.errors_cm) mean += error / frames;
    std::printf("%-22s %6d %8.2f %8.2f %6.2f %6.2f %6.3f %8.1f %9.2f\n", name.c_str(), r.clips, mean, Quantile(r.errors_cm, 0.95), r.jerk / frames, r.skate / frames,
                r.feet / frames, r.likelihood / frames, r.time_ms / frames);
  }
}
