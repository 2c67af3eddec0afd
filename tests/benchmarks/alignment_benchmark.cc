// What alignment from a standing phase is worth: simulated sensors that sit askew, reconstructed as they are told to sit and aligned.
//
//   alignment_benchmark --data RECORDINGS [--methods graph,olng] [--tune]
//
// RECORDINGS holds bnr/ and real_imu/. The model is of the walks and turns of bnr, without the test clips (of every folder and style number n/2 of n by name; with --tune number n/4, on which
// constants were chosen). bnr holds no standing: before every test clip, the readings have two seconds of the person of neura_s02 standing, put on bnr's skeleton. Four sensors at wrists and ankles are
// turned by a given angle about a random axis each.
//
// Error: root mean square distance of the joints in the pelvis frame, cm, over the frames of the walk; mean and 95th percentile. Left: mean angle between how sensors sit and how they are found to,
// degrees.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "datasets/augmentation.h"
#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/dataset_loader.h"
#include "datasets/quantile.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "datasets/virtual_sensors.h"
#include "graph/graph_builder.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/readings_reconstruction.h"
#include "tests/benchmarks/upright_rest.h"
#include "tests/support/random_matrix.h"

namespace {

using namespace morphograph;

constexpr int kStandingFrames = 60;
const std::vector<std::string> kSensors = {"left_wrist", "right_wrist", "left_ankle", "right_ankle"};

struct Bnr {
  std::vector<MotionClip> tests;
  std::shared_ptr<const MotionGraph> graph;  // of the others
  MotionClip standing;                       // at 30 Hz, on the same skeleton
};

// The other way about than WithRestPose().
MotionClip WithOwnAxes(const MotionClip& turned, const std::shared_ptr<const Skeleton>& own, const std::vector<Eigen::Quaterniond>& usual) {
  MotionClip clip(own, turned.frame_rate_hz(), turned.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < own->joint_count(); ++j) {
      const Eigen::Quaterniond above = own->parent(j) < 0 ? Eigen::Quaterniond::Identity() : usual[static_cast<std::size_t>(own->parent(j))];
      clip.rotation(f, j) = (above.conjugate() * turned.rotation(f, j) * usual[static_cast<std::size_t>(j)]).normalized();
    }
  }
  clip.root_positions() = turned.root_positions();
  return clip;
}

Bnr Load(const std::filesystem::path& data, bool tune) {
  const std::filesystem::path bnr = data / "bnr/dataset-2";
  const Dataset dataset = LoadDataset({bnr / "walk", bnr / "walk-turn-left", bnr / "walk-turn-right"});
  std::vector<MotionClip> clips;
  std::map<std::pair<std::string, std::string>, std::vector<std::size_t>> kinds;
  for (const LoadedClip& loaded : dataset.clips) clips.push_back(loaded.clip);
  std::vector<MotionClip> levelled;
  for (AugmentedClip& level : Augment(clips, {})) {
    if (level.made) continue;
    kinds[{dataset.clips[levelled.size()].file.parent_path().filename().string(), level.clip.style}].push_back(levelled.size());
    levelled.push_back(std::move(level.clip));
  }
  std::set<std::size_t> out, tests;
  for (const auto& [kind, members] : kinds) {
    out.insert(members[members.size() / 2]);
    tests.insert(members[members.size() / (tune ? 4 : 2)]);
  }
  out.insert(tests.begin(), tests.end());
  Bnr loaded;
  std::vector<TrainingClip> training;
  for (std::size_t i = 0; i < levelled.size(); ++i) {
    if (tests.contains(i)) loaded.tests.push_back(levelled[i]);
    if (!out.contains(i)) training.push_back({levelled[i], false, static_cast<int>(training.size())});
  }
  TrainingOptions options;
  options.keep_recordings = true;
  options.jobs = 2;
  loaded.graph = BuildGraph(training, options);

  std::vector<MotionClip> some;
  for (std::size_t i = 0; i < levelled.size(); i += 12) some.push_back(levelled[i]);
  const std::vector<Eigen::Quaterniond> usual = UsualPose(some);
  MotionClip person = ImportClip(ReadBvhFile(data / "real_imu/neura_s02/S02-Trial-Walk-1_xsens.bvh"));
  person = Resample(person.Slice(300, 300), 30);  // of 11 s of standing
  const MotionClip upright = WithRestPose(some.front(), usual);
  loaded.standing = WithOwnAxes(Retarget(person, upright.shared_skeleton()), some.front().shared_skeleton(), usual).Slice(5, kStandingFrames);
  return loaded;
}

struct Row {
  std::vector<double> errors_cm, left_deg;
};

void Print(const std::string& name, const Row& row) {
  double mean = 0, left = 0;
  for (const double error : row.errors_cm) mean += error / static_cast<double>(row.errors_cm.size());
  for (const double angle : row.left_deg) left += angle / static_cast<double>(row.left_deg.size());
  std::printf("  %-46s %6.2f %6.2f %8.1f\n", name.c_str(), mean, Quantile(row.errors_cm, 0.95), left);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path data;
  bool tune = false;
  std::vector<std::string> methods = {"graph", "olng"};
  double noise = 0;
  int late = 0;
  CLI::App app("Alignment from a standing phase");
  app.add_option("--data", data, "folder with bnr and real_imu")->required();
  app.add_flag("--tune", tune, "the clips to choose constants on");
  app.add_option("--methods", methods, "of reconstruction")->delimiter(',');
  app.add_option("--noise", noise, "of sensors, m/s^2 per axis");
  app.add_option("--late", late, "frames by which the last sensor comes late");
  CLI11_PARSE(app, argc, argv);
  const Bnr bnr = Load(data, tune);
  const std::vector<Placement> placements = PlacementsAtJoints(kSensors);
  const WornSensors worn = WornBy({bnr.standing}, placements), guessed = WornBy(SourceOf(*bnr.graph).clips, placements);
  for (Eigen::Index s = 0; s < worn.up.cols(); ++s)
    std::printf("%s: what it reads standing is %.1f degrees off the guess\n", kSensors[static_cast<std::size_t>(s)].c_str(), 180 / std::numbers::pi * std::acos(worn.up.col(s).dot(guessed.up.col(s))));
  for (const std::string& name : methods) {
    const ReconstructionMethod method = ParseMethod(name).value();
    const auto reconstructor = MakeReconstructor(bnr.graph, method, placements, 2);
    std::printf("\n%s, %zu clips\n  %-46s %6s %6s %8s\n", name.c_str(), bnr.tests.size(), "", "cm", "95 %", "left, deg");
    for (const double askew_deg : {0.0, 10.0, 20.0, 30.0}) {
      for (const bool align : {false, true}) {
        Row row;
        std::mt19937_64 rng(7);
        for (const MotionClip& truth : bnr.tests) {
          Readings readings = VirtualAccelerations(truth, placements, kReconstructionRate_hz);
          const Eigen::MatrixXd standing = VirtualAccelerations(bnr.standing, placements, kReconstructionRate_hz).values, walking = readings.values;
          readings.values.resize(walking.rows(), standing.cols() + walking.cols());
          readings.values << standing, walking;
          readings.times_s.clear();
          for (Eigen::Index i = 0; i < readings.values.cols(); ++i) readings.times_s.push_back(static_cast<double>(i) / kReconstructionRate_hz);
          std::vector<Eigen::Quaterniond> turns;
          for (Eigen::Index s = 0; s < readings.sensor_count(); ++s) {
            const Eigen::Vector3d axis = testing::RandomRotation(rng) * Eigen::Vector3d::UnitX();
            turns.emplace_back(Eigen::AngleAxisd(askew_deg * std::numbers::pi / 180, axis));
            readings.values.middleRows<3>(3 * s) = (turns.back().conjugate().toRotationMatrix() * readings.values.middleRows<3>(3 * s)).eval();
          }
          if (late > 0) {
            const Eigen::MatrixXd last = readings.values.bottomRows<3>();
            readings.values.bottomRows<3>() << last.col(0).replicate(1, late), last.leftCols(last.cols() - late);
          }
          readings = WithFaults(readings, {.noise = noise}, 1);
          ReconstructionRequest request;
          request.method = method;
          request.readings = readings;
          request.placements = placements;
          if (align) request.alignment.emplace();
          const ReconstructedReadings made = ReconstructReadings(*bnr.graph, request, [&](const std::vector<Placement>&) { return reconstructor; });
          const ReconstructionQuality quality =
              CompareClips(made.reconstruction.clip.Slice(kStandingFrames, made.reconstruction.clip.frame_count() - kStandingFrames), Resample(truth, kReconstructionRate_hz));
          row.errors_cm.insert(row.errors_cm.end(), quality.frame_rms_cm.begin(), quality.frame_rms_cm.end());
          for (std::size_t s = 0; s < turns.size(); ++s) {
            const Eigen::Quaterniond found = made.alignment ? made.alignment->sensors[s].told_from_worn : Eigen::Quaterniond::Identity();
            row.left_deg.push_back(180 / std::numbers::pi * found.angularDistance(turns[s]));
          }
          if (align && late > 0) std::fprintf(stderr, "delays %.3f %.3f %.3f %.3f\n", made.alignment->sensors[0].delay_s, made.alignment->sensors[1].delay_s, made.alignment->sensors[2].delay_s, made.alignment->sensors[3].delay_s);
        }
        Print("askew by " + std::to_string(static_cast<int>(askew_deg)) + " degrees" + (align ? ", aligned" : ""), row);
      }
    }
  }
}
