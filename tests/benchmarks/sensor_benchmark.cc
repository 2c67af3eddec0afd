// Motion from a few accelerometers: how near it comes to the truth, and what a frame costs (one thread, processor time).
//
//   sensor_benchmark --data bnr/walk bnr/walk-turn-left bnr/walk-turn-right                 test clips out of the base, their styles in it
//   sensor_benchmark --data … --split style                                                 and without their style
//   sensor_benchmark --data cmu/07 cmu/08 --split folder                                    without the folder that they are from (a person)
//   sensor_benchmark --data … --folds 8                                                     every clip tried, on a base of the seven eighths that it is not in
//   sensor_benchmark --data … --rows plain priors faults tempo body sensors reversed        which tables; plain alone when not given
//   sensor_benchmark --data … --speed 600000                                                a base of that many frames, by mirrored and retimed copies
//
// Sensors are simulated on the body of the recording. Of every folder and style the clip in the middle (of n clips number n/2, counted from 0 by name) is a test clip, where
// there are two or more; it and its mirrored copy are in no base. With --split folder all clips of the folder are. --tune takes number n/4 and leaves the
// test clips out of every base too: defaults were chosen there.
//
// Error: root mean square distance of the joints in the pelvis frame, cm, a value a frame, from the first frame on; mean and 95th percentile are over all frames of all test
// clips. Jerk: times the truth's, by clips weighted by frames. Lower is better for all but jerk, which is best at 1.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "datasets/atomic_file.h"
#include "datasets/augmentation.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/dataset_loader.h"
#include "datasets/forward_kinematics.h"
#include "datasets/quantile.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/olng_estimator.h"
#include "synthesis/sensors/olng_recording.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/benchmarks/upright_rest.h"
#include "tests/support/body_size.h"

namespace {

using namespace morphograph;

constexpr double kRate_hz = 30;
const std::vector<std::string> kFour = {"left_wrist", "right_wrist", "left_ankle", "right_ankle"};

struct Recording {
  MotionClip clip;
  std::string folder;
};

bool StandsAtRest(const Skeleton& skeleton) {
  const std::vector<Eigen::Quaterniond> none(static_cast<std::size_t>(skeleton.joint_count()), Eigen::Quaterniond::Identity());
  WorldPose pose;
  ForwardKinematics(skeleton, none.data(), Eigen::Vector3d::Zero(), &pose);
  const Eigen::Vector3d leg = pose.positions.col(skeleton.roles()[JointRole::kLeftAnkle]) - pose.positions.col(skeleton.roles()[JointRole::kLeftHip]);
  return leg.normalized().y() < -0.8;
}

// Where skeletons of both kinds are to go into one base, those that do not stand at rest are given axes in which they do.
void MakeAllStand(std::vector<Recording>* recordings) {
  constexpr std::size_t kEvery = 12;
  std::vector<MotionClip> lying;
  std::size_t n = 0;
  for (const Recording& recording : *recordings) {
    if (!StandsAtRest(recording.clip.skeleton()) && n++ % kEvery == 0) lying.push_back(recording.clip);
  }
  if (n == 0 || n == recordings->size()) return;
  const std::vector<Eigen::Quaterniond> usual = UsualPose(lying);
  for (Recording& recording : *recordings) {
    if (!StandsAtRest(recording.clip.skeleton())) recording.clip = WithRestPose(recording.clip, usual);
  }
}

std::vector<Recording> Load(const std::vector<std::filesystem::path>& folders) {
  std::vector<Recording> recordings;
  for (const std::filesystem::path& path : folders) {  // one at a time: names of styles are found among files of one kind
    const Dataset dataset = LoadDataset({path});
    std::vector<MotionClip> clips;
    for (const LoadedClip& loaded : dataset.clips) clips.push_back(loaded.clip);
    std::size_t n = 0;
    // On a level floor, as models keep their recordings.
    for (AugmentedClip& level : Augment(clips, {}, 2)) {
      if (level.made) continue;
      const std::string folder = dataset.clips[n++].file.parent_path().filename().string();
      if (level.clip.duration_s() >= 0.5) recordings.push_back({std::move(level.clip), folder});
    }
  }
  MakeAllStand(&recordings);
  return recordings;
}

// One base and the clips that it is tried on.
struct Split {
  std::vector<MotionClip> training;  // on one skeleton
  std::vector<int> tests;            // into the recordings
};

// Clips to be tried: of every folder and style one.
std::vector<int> TestClips(const std::vector<Recording>& recordings, double place) {
  std::map<std::pair<std::string, std::string>, std::vector<int>> groups;
  for (std::size_t i = 0; i < recordings.size(); ++i) groups[{recordings[i].folder, recordings[i].clip.style}].push_back(static_cast<int>(i));
  std::vector<int> tests;
  for (const auto& [name, members] : groups) {
    if (members.size() >= 2) tests.push_back(members[static_cast<std::size_t>(place * static_cast<double>(members.size()))]);
  }
  return tests;
}

// Every recording is tried: those whose number leaves the same remainder are tried together, on a base of all others.
std::vector<Split> MakeFolds(const std::vector<Recording>& recordings, int folds) {
  std::vector<Split> splits(static_cast<std::size_t>(folds));
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i) {
    for (int fold = 0; fold < folds; ++fold) {
      Split& split = splits[static_cast<std::size_t>(fold)];
      if (i % folds == fold) {
        split.tests.push_back(i);
      } else {
        const MotionClip& clip = recordings[static_cast<std::size_t>(i)].clip;
        split.training.push_back(split.training.empty() ? clip : Retarget(clip, split.training.front().shared_skeleton()));
      }
    }
  }
  return splits;
}

std::vector<Split> MakeSplits(const std::vector<Recording>& recordings, const std::string& kind, bool tune, const std::vector<std::string>& only = {}) {
  const std::vector<int> final_tests = TestClips(recordings, 0.5);
  std::vector<int> tests = tune ? TestClips(recordings, 0.25) : final_tests;
  if (!only.empty()) {
    std::erase_if(tests, [&](int i) {
      return std::find(only.begin(), only.end(), recordings[static_cast<std::size_t>(i)].folder) == only.end();
    });
  }
  const auto key = [&](int i) {
    const Recording& recording = recordings[static_cast<std::size_t>(i)];
    return kind == "style" ? recording.clip.style : kind == "folder" ? recording.folder : std::string();
  };
  std::set<std::string> keys;
  for (const int i : tests) keys.insert(key(i));
  std::vector<Split> splits;
  for (const std::string& left_out : keys) {
    Split split;
    std::set<int> out(final_tests.begin(), final_tests.end());
    out.insert(tests.begin(), tests.end());
    for (int i = 0; i < static_cast<int>(recordings.size()); ++i) {
      if (kind != "clip" && key(i) == left_out) out.insert(i);
      if (kind == "folder" && key(i) == left_out) split.tests.push_back(i);
    }
    for (const int i : tests) {
      if (kind != "folder" && key(i) == left_out) split.tests.push_back(i);
    }
    for (int i = 0; i < static_cast<int>(recordings.size()); ++i) {
      // Other people's clips are all in the base.
      const bool in = kind == "folder" ? key(i) != left_out : out.count(i) == 0;
      if (!in) continue;
      const MotionClip& clip = recordings[static_cast<std::size_t>(i)].clip;
      split.training.push_back(split.training.empty() ? clip : Retarget(clip, split.training.front().shared_skeleton()));
    }
    splits.push_back(std::move(split));
  }
  return splits;
}

SensorFaults BadSensors() {
  SensorFaults faults;
  faults.noise = 1.2;
  faults.mounting_rad = 10 * M_PI / 180;
  return faults;
}

// What a test clip is turned into before its sensors are simulated, and what is wrong with them.
struct Trial {
  double tempo = 1, size = 1;
  SensorFaults faults;
};

double MeanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

struct Errors {
  std::vector<double> errors_cm, clip_means_cm, without_fingers_cm;
  std::vector<int> clip_frames;
  double jerk = 0, angle_deg = 0, velocity_cm_s = 0, contacts = 0;
  long long frames = 0;

  void Add(const ReconstructionQuality& quality) {
    errors_cm.insert(errors_cm.end(), quality.frame_rms_cm.begin(), quality.frame_rms_cm.end());
    clip_means_cm.push_back(quality.position_rms_cm);
    clip_frames.push_back(quality.frames);
    jerk += quality.jerk_ratio * quality.frames;
    angle_deg += quality.angle_deg * quality.frames;
    velocity_cm_s += quality.velocity_error_cm_s * quality.frames;
    contacts += quality.contact_agreement * quality.frames;
    frames += quality.frames;
  }
  double mean() const { return MeanOf(errors_cm); }
};

// The same error, a value a frame, over the joints that are not below a wrist: fingers, which some skeletons have, follow the hands.
std::vector<double> ErrorsWithoutFingers(const MotionBase& base, const std::vector<BasePose>& poses, const std::vector<BasePose>& truth) {
  const Skeleton& skeleton = base.skeleton();
  std::vector<Eigen::Index> kept;
  for (std::size_t n = 0; n < base.measured_joints().size(); ++n) {
    bool finger = false;
    for (int j = skeleton.parent(base.measured_joints()[n]); j >= 0; j = skeleton.parent(j))
      finger = finger || j == skeleton.roles()[JointRole::kLeftWrist] || j == skeleton.roles()[JointRole::kRightWrist];
    if (!finger) kept.push_back(static_cast<Eigen::Index>(n));
  }
  std::vector<double> errors_cm;
  for (std::size_t f = 0; f < poses.size(); ++f) {
    const Eigen::VectorXd off = MeasuredPositions(base, poses[f].rotations) - MeasuredPositions(base, truth[f].rotations);
    double sum = 0;
    for (const Eigen::Index n : kept) sum += off.segment<3>(3 * n).squaredNorm();
    errors_cm.push_back(100 * std::sqrt(sum / static_cast<double>(kept.size())));
  }
  return errors_cm;
}

struct Outcome : Errors {
  std::map<std::string, Errors> kinds;  // by folder
  Errors alone, with_like;              // clips that are the only one of their folder and style, and all others
};

void PrintHead(const std::string& title) {
  std::printf("\n%-62s %7s %7s %9s %7s %7s %9s %9s\n", title.c_str(), "cm", "95 %", "/ nearest", "jerk x", "angle", "velocity", "contacts");
}

void Print(const std::string& name, const Errors& outcome, double nearest_cm) {
  const auto share = static_cast<double>(outcome.frames);
  std::printf("%-62s %7.2f %7.2f %9.2f %7.2f %6.1f° %4.0f cm/s %7.1f %%\n", name.c_str(), outcome.mean(), Quantile(outcome.errors_cm, 0.95),
              outcome.mean() / nearest_cm, outcome.jerk / share, outcome.angle_deg / share, outcome.velocity_cm_s / share, 100 * outcome.contacts / share);
  if (!outcome.without_fingers_cm.empty() && outcome.without_fingers_cm != outcome.errors_cm && std::abs(MeanOf(outcome.without_fingers_cm) - outcome.mean()) > 0.005)
    std::printf("    without fingers: %.2f cm, 95 %% %.2f\n", MeanOf(outcome.without_fingers_cm), Quantile(outcome.without_fingers_cm, 0.95));
  std::fflush(stdout);
}

// By kind of motion, and every clip counted alike.
void PrintKinds(const Outcome& outcome, const Outcome& nearest) {
  for (const auto& [folder, kind] : outcome.kinds) Print("  " + folder + ", " + std::to_string(kind.clip_means_cm.size()) + " clips", kind, nearest.kinds.at(folder).mean());
  double sum = 0;
  for (const double mean : outcome.clip_means_cm) sum += mean;
  std::printf("  every clip counted alike: %.2f cm, median clip %.2f cm\n", sum / static_cast<double>(outcome.clip_means_cm.size()), Median(outcome.clip_means_cm));
}

// The clips to which the base's nearest poses come within a distance, and the others, which nothing in the base is like.
void PrintLike(const Outcome& outcome, const Outcome& bound) {
  constexpr double kLike_cm = 4;
  double sums[2] = {0, 0}, bounds[2] = {0, 0};
  long long frames[2] = {0, 0};
  int clips[2] = {0, 0};
  for (std::size_t i = 0; i < outcome.clip_means_cm.size(); ++i) {
    const int side = bound.clip_means_cm[i] <= kLike_cm ? 0 : 1;
    sums[side] += outcome.clip_frames[i] * outcome.clip_means_cm[i];
    bounds[side] += outcome.clip_frames[i] * bound.clip_means_cm[i];
    frames[side] += outcome.clip_frames[i];
    ++clips[side];
  }
  for (const int side : {0, 1}) {
    if (clips[side] == 0) continue;
    const auto count = static_cast<double>(frames[side]);
    std::printf("  %d clips %s %.0f cm of the base's nearest poses: %.2f cm (nearest poses %.2f), %lld frames\n", clips[side],
                side == 0 ? "within" : "beyond", kLike_cm, sums[side] / count, bounds[side] / count, frames[side]);
  }
}

void PrintHistogram(const std::string& name, const Outcome& outcome) {
  constexpr double kBin_cm = 0.5;
  constexpr int kBins = 24;
  std::vector<int> counts(kBins, 0);
  for (const double error : outcome.errors_cm) ++counts[static_cast<std::size_t>(std::min<int>(kBins - 1, static_cast<int>(error / kBin_cm)))];
  std::printf("%-28s", name.c_str());
  for (const int count : counts) std::printf("%4.0f", 100.0 * count / static_cast<double>(outcome.errors_cm.size()));
  std::printf("\n");
}

struct TestClip {
  std::string name;
  MotionClip truth;  // on the base's skeleton and at its rate
  Eigen::MatrixXd readings;
};

// Sensors of the base as they sit on the recorded body, whose joints may have other axes: each is turned as its joint is turned on the average against the same joint of the base.
std::vector<Placement> WornBy(const MotionClip& body, const MotionClip& on_base, std::vector<Placement> sensors) {
  if (SameRestPose(body.skeleton(), on_base.skeleton())) return sensors;
  const std::vector<int> own = JointsOf(sensors, body.skeleton()), theirs = JointsOf(sensors, on_base.skeleton());
  std::vector<Eigen::Matrix3d> turns(sensors.size(), Eigen::Matrix3d::Zero());
  for (int f = 0; f < body.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(body, f), of_base = ForwardKinematics(on_base, f);
    for (std::size_t s = 0; s < sensors.size(); ++s)
      turns[s] += (pose.rotations[static_cast<std::size_t>(own[s])].conjugate() * of_base.rotations[static_cast<std::size_t>(theirs[s])]).toRotationMatrix();
  }
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turns[s], Eigen::ComputeFullU | Eigen::ComputeFullV);
    sensors[s].joint_from_sensor = Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())) * sensors[s].joint_from_sensor;
  }
  return sensors;
}

TestClip Simulated(const Recording& recording, const MotionBase& base, const Trial& trial, std::uint64_t seed) {
  const MotionClip played = trial.tempo == 1 ? recording.clip : Retimed(recording.clip, recording.clip.frame_rate_hz() * trial.tempo);
  const MotionClip on_base = Retarget(played, base.shared_skeleton());
  Readings readings = VirtualAccelerations(trial.size == 1 ? played : testing::OfSize(played, trial.size), WornBy(played, on_base, base.sensors()), base.frame_rate_hz());
  readings = WithFaults(readings, trial.faults, seed);
  return {recording.clip.name, Resample(on_base, base.frame_rate_hz()), readings.values};
}

std::vector<BasePose> Reconstruct(PoseEstimator& estimator, const Eigen::MatrixXd& readings) {
  std::vector<BasePose> poses;
  for (Eigen::Index f = 0; f < readings.cols(); ++f) poses.push_back(estimator.Next(readings.col(f)));
  return poses;
}

class Study {
 public:
  Study(const std::vector<Recording>& recordings, std::vector<Split> splits, std::vector<double> tempos, std::filesystem::path out, bool each)
      : recordings_(recordings), splits_(std::move(splits)), tempos_(std::move(tempos)), out_(std::move(out)), each_(each) {}

  void UseBases(const std::vector<std::string>& sensors, MotionBaseOptions options) {
    bases_.clear();
    options.tempos = tempos_;
    options.jobs = 2;
    for (const Split& split : splits_) bases_.push_back(std::make_shared<MotionBase>(split.training, PlacementsAtJoints(sensors), options));
  }

  // As a stream, or whole, with the future known.
  Outcome Try(const OlngOptions& options, const Trial& trial, bool whole = false) {
    Outcome outcome;
    for (std::size_t s = 0; s < splits_.size(); ++s) {
      const auto model = std::make_shared<OlngModel>(bases_[s], options);
      for (const int i : splits_[s].tests) {
        const TestClip test = Simulated(recordings_[static_cast<std::size_t>(i)], *bases_[s], trial, static_cast<std::uint64_t>(i));
        OlngEstimator estimator(model);
        const std::vector<BasePose> poses = whole ? ReconstructRecording(model, test.readings) : Reconstruct(estimator, test.readings);
        const ReconstructionQuality quality = CompareWithTruth(*bases_[s], poses, test.truth);
        outcome.Add(quality);
        outcome.kinds[recordings_[static_cast<std::size_t>(i)].folder].Add(quality);
        (IsAlone(i) ? outcome.alone : outcome.with_like).Add(quality);
        const std::vector<double> bare = ErrorsWithoutFingers(*bases_[s], poses, PosesOf(*bases_[s], test.truth));
        outcome.without_fingers_cm.insert(outcome.without_fingers_cm.end(), bare.begin(), bare.end());
        if (each_) std::printf("    %-40s %6.2f cm, jerk x %.2f\n", test.name.c_str(), quality.position_rms_cm, quality.jerk_ratio);
        if (!out_.empty()) Write(*bases_[s], test, poses);
      }
    }
    return outcome;
  }

  Outcome Nearest(const Trial& trial) {
    OlngOptions options;
    options.pose = OlngPose::kNearest;
    return Try(options, trial);
  }

  // Of every true pose the frame of the base that is most like it: what no choice of one frame can better.
  Outcome NearestPose() {
    Outcome outcome;
    for (std::size_t s = 0; s < splits_.size(); ++s) {
      const MotionBase& base = *bases_[s];
      const Eigen::VectorXf norms = base.positions().colwise().squaredNorm();
      for (const int i : splits_[s].tests) {
        const TestClip test = Simulated(recordings_[static_cast<std::size_t>(i)], base, {}, 0);
        std::vector<BasePose> poses;
        for (const BasePose& truth : PosesOf(base, test.truth)) {
          const Eigen::VectorXf wanted = MeasuredPositions(base, truth.rotations).cast<float>();
          Eigen::Index best = 0;
          (norms - 2 * (base.positions().transpose() * wanted)).minCoeff(&best);
          poses.push_back(base.Pose(best));
        }
        const ReconstructionQuality quality = CompareWithTruth(base, poses, test.truth);
        outcome.Add(quality);
        outcome.kinds[recordings_[static_cast<std::size_t>(i)].folder].Add(quality);
        if (each_) std::printf("    %-40s %6.2f cm\n", test.name.c_str(), quality.position_rms_cm);
      }
    }
    return outcome;
  }

  // Of the ends of the paths that olng makes its pose of, the one that is most like the true pose: what no weighing of these paths can better, but by a mean of several.
  Outcome NearestPath(OlngOptions options) {
    options.pose = OlngPose::kWeightedMean;
    Outcome outcome;
    for (std::size_t s = 0; s < splits_.size(); ++s) {
      const MotionBase& base = *bases_[s];
      const auto model = std::make_shared<OlngModel>(bases_[s], options);
      for (const int i : splits_[s].tests) {
        const TestClip test = Simulated(recordings_[static_cast<std::size_t>(i)], base, {}, 0);
        OlngEstimator estimator(model);
        std::vector<BasePose> poses;
        for (const BasePose& truth : PosesOf(base, test.truth)) {
          estimator.Next(test.readings.col(static_cast<Eigen::Index>(poses.size())));
          const Eigen::VectorXf wanted = MeasuredPositions(base, truth.rotations).cast<float>();
          int best = estimator.poser()->best_paths().front().frame;
          for (const NeighbourPath& path : estimator.poser()->best_paths())
            if ((base.positions().col(path.frame) - wanted).squaredNorm() < (base.positions().col(best) - wanted).squaredNorm()) best = path.frame;
          poses.push_back(base.Pose(best));
        }
        const ReconstructionQuality quality = CompareWithTruth(base, poses, test.truth);
        outcome.Add(quality);
        outcome.kinds[recordings_[static_cast<std::size_t>(i)].folder].Add(quality);
      }
    }
    return outcome;
  }

  void Describe() const {
    std::printf("%zu base%s; frames in the first: %lld, at %.0f Hz; %zu joints measured\ntest clips:", bases_.size(), bases_.size() == 1 ? "" : "s",
                static_cast<long long>(bases_.front()->frame_count()), bases_.front()->frame_rate_hz(), bases_.front()->measured_joints().size());
    std::size_t tests = 0;
    for (const Split& split : splits_) tests += split.tests.size();
    if (tests == recordings_.size()) std::printf(" all %zu", tests);
    for (const Split& split : splits_) {
      for (const int i : split.tests) {
        if (tests < recordings_.size()) std::printf(" %s", recordings_[static_cast<std::size_t>(i)].clip.name.c_str());
      }
    }
    const OlngModel model(bases_.front(), {});
    std::printf("\nK = %d, I = %d, M = %d\n", model.options().neighbours, model.options().paths, model.options().graph.window_frames);
  }

 private:
  bool IsAlone(int recording) const {
    const Recording& one = recordings_[static_cast<std::size_t>(recording)];
    return std::count_if(recordings_.begin(), recordings_.end(), [&](const Recording& other) { return other.folder == one.folder && other.clip.style == one.clip.style; }) == 1;
  }

  void Write(const MotionBase& base, const TestClip& test, const std::vector<BasePose>& poses) const {
    std::filesystem::create_directories(out_);
    WriteFileAtomically(out_ / (test.name + ".bvh"), WriteBvh(ExportClip(base.Assemble(poses))));
    WriteFileAtomically(out_ / (test.name + "_truth.bvh"), WriteBvh(ExportClip(base.Assemble(PosesOf(base, test.truth)))));
  }

  const std::vector<Recording>& recordings_;
  std::vector<Split> splits_;
  std::vector<double> tempos_;  // of more copies in the bases
  std::filesystem::path out_;
  bool each_;
  std::vector<std::shared_ptr<const MotionBase>> bases_;
};

OlngOptions WithPose(OlngOptions options, OlngPose pose) {
  options.pose = pose;
  return options;
}

OlngOptions WithPrior(OlngOptions options, PriorKind kind) {
  options.energy.kind = kind;
  return options;
}

void PlainRows(Study& study, const OlngOptions& options) {
  PrintHead("four accelerometers");
  const Outcome nearest = study.Nearest({}), bound = study.NearestPose();
  Print("the base's pose nearest to the true one (a bound)", bound, nearest.mean());
  PrintKinds(bound, nearest);
  const Outcome path = study.NearestPath(options);
  Print("of the paths' ends that nearest to the true one (a bound)", path, nearest.mean());
  PrintKinds(path, nearest);
  Print("nearest neighbour, no paths", nearest, nearest.mean());
  Print("weighted mean of the paths, no energy", study.Try(WithPose(options, OlngPose::kWeightedMean), {}), nearest.mean());
  const Outcome olng = study.Try(options, {});
  Print("olng", olng, nearest.mean());
  PrintKinds(olng, nearest);
  PrintLike(olng, bound);
  const Outcome whole = study.Try(options, {}, true);
  Print("olng, whole recordings: readings to come tell as well", whole, nearest.mean());
  PrintKinds(whole, nearest);
}

// Every clip tried once.
void FoldRows(Study& study, const OlngOptions& options) {
  PrintHead("every clip, out of the base");
  const Outcome nearest = study.Nearest({});
  Print("nearest neighbour, no paths", nearest, nearest.mean());
  for (const bool whole : {false, true}) {
    const Outcome olng = study.Try(options, {}, whole);
    Print(whole ? "olng, whole recordings: readings to come tell as well" : "olng", olng, nearest.mean());
    PrintKinds(olng, nearest);
    if (olng.alone.frames == 0) continue;
    const auto count = [](const Errors& errors) { return std::to_string(errors.clip_means_cm.size()) + " clips "; };
    Print("  " + count(olng.with_like) + "that are not alone of their folder and style", olng.with_like, nearest.with_like.mean());
    Print("  " + count(olng.alone) + "that are", olng.alone, nearest.alone.mean());
  }
}

void PriorRows(Study& study, const OlngOptions& options) {
  PrintHead("priors");
  const double nearest = study.Nearest({}).mean();
  Print("kernels", study.Try(WithPrior(options, PriorKind::kKernel), {}), nearest);
  Print("normal distributions, regularised", study.Try(WithPrior(options, PriorKind::kGaussian), {}), nearest);
  OlngOptions bare = WithPrior(options, PriorKind::kGaussian);
  bare.energy.ridge_m /= 10;
  bare.energy.ridge_rad /= 10;
  Print("normal distributions, a tenth of the ridge", study.Try(bare, {}), nearest);
  OlngOptions least = WithPrior(options, PriorKind::kGaussianLeastAcceleration);
  Print("normal distribution of the pose, least acceleration", study.Try(least, {}), nearest);
  least.energy.least_acceleration_m = 0.03;
  Print("the same, accelerations weighted for smoothness", study.Try(least, {}), nearest);
  least = WithPrior(options, PriorKind::kGaussianLeastAcceleration);
  least.energy.ridge_m = 0.003;
  least.energy.ridge_rad = 0.01;
  Print("the same, regularised by 3 mm and 0.01 rad", study.Try(least, {}), nearest);
  least.energy.ridge_m = 0.0003;
  least.energy.ridge_rad = 0.001;
  Print("the same, by no more than 0.3 mm and 0.001 rad", study.Try(least, {}), nearest);
}

void TrialRows(Study& study, const OlngOptions& options, const std::string& title, const std::vector<std::pair<std::string, Trial>>& trials) {
  PrintHead(title);
  for (const auto& [name, trial] : trials) Print(name, study.Try(options, trial), study.Nearest(trial).mean());
}

void SensorRows(Study& study, const OlngOptions& options) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> sets = {
      {"1: right wrist", {"right_wrist"}},
      {"1: right ankle", {"right_ankle"}},
      {"2: wrists", {"left_wrist", "right_wrist"}},
      {"2: ankles", {"left_ankle", "right_ankle"}},
      {"2: left wrist, right ankle", {"left_wrist", "right_ankle"}},
      {"3: wrists, pelvis", {"left_wrist", "right_wrist", "hips"}},
      {"3: wrists, right ankle", {"left_wrist", "right_wrist", "right_ankle"}},
      {"4: wrists, ankles", kFour},
      {"5: wrists, ankles, pelvis", {"left_wrist", "right_wrist", "left_ankle", "right_ankle", "hips"}},
      {"5: wrists, ankles, head", {"left_wrist", "right_wrist", "left_ankle", "right_ankle", "head"}},
      {"6: wrists, ankles, pelvis, head", {"left_wrist", "right_wrist", "left_ankle", "right_ankle", "hips", "head"}}};
  PrintHead("sensors");
  std::vector<std::pair<std::string, Outcome>> outcomes;
  for (const auto& [name, joints] : sets) {
    study.UseBases(joints, {});
    outcomes.emplace_back(name, study.Try(options, {}));
    Print(name, outcomes.back().second, study.Nearest({}).mean());
  }
  std::printf("\nframes (%%) by error, bins of 0.5 cm from 0; the last holds all above\n");
  for (const auto& [name, outcome] : outcomes) PrintHistogram(name, outcome);
  study.UseBases(kFour, {});
}

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void SpeedRow(const std::string& name, const std::vector<TestClip>& tests, const std::function<std::function<void(const Eigen::VectorXd&)>()>& start) {
  std::vector<double> times_ms;
  for (const TestClip& test : tests) {
    const std::function<void(const Eigen::VectorXd&)> step = start();
    for (Eigen::Index f = 0; f < test.readings.cols(); ++f) {
      const Eigen::VectorXd reading = test.readings.col(f);
      const double before = ThreadSeconds();
      step(reading);
      times_ms.push_back(1e3 * (ThreadSeconds() - before));
    }
  }
  double sum = 0;
  for (const double time : times_ms) sum += time;
  std::printf("%-40s mean %6.2f ms, 95 %% %6.2f ms, most %6.2f ms a frame (%zu frames)\n", name.c_str(), sum / static_cast<double>(times_ms.size()),
              Quantile(times_ms, 0.95), *std::max_element(times_ms.begin(), times_ms.end()), times_ms.size());
  std::fflush(stdout);
}

void Speed(const std::vector<Recording>& recordings, OlngOptions options, long long frames) {
  std::vector<Split> splits = MakeSplits(recordings, "clip", false);
  long long once = 0;
  for (const MotionClip& clip : splits.front().training) once += std::llround(clip.duration_s() * kRate_hz);
  MotionBaseOptions base_options;
  base_options.frame_rate_hz = kRate_hz;
  // Tempos about 1 until there are enough frames, mirrored ones counted.
  double copies = 1;
  for (int n = 1; 2 * once * copies < frames; ++n) {
    base_options.tempos.push_back(1 + (n % 2 == 0 ? 0.06 : -0.06) * ((n + 1) / 2));
    copies += 1 / base_options.tempos.back();
  }
  double start = ThreadSeconds();
  const auto base = std::make_shared<MotionBase>(splits.front().training, PlacementsAtJoints(kFour), base_options);
  std::printf("\nN = %lld frames (mirrored, at %zu tempos), made in %.0f s\n", static_cast<long long>(base->frame_count()), base_options.tempos.size() + 1,
              ThreadSeconds() - start);
  options.neighbours = 4096;
  options.paths = 256;
  start = ThreadSeconds();
  const auto model = std::make_shared<OlngModel>(base, options);
  std::printf("K = 4096, I = 256; kd-tree of %.0f MB made in %.2f s\n", static_cast<double>(model->search().memory_bytes()) / 1e6, ThreadSeconds() - start);
  std::vector<TestClip> tests;
  // Every third, which takes long enough.
  for (std::size_t i = 0; i < splits.front().tests.size(); i += 3)
    tests.push_back(Simulated(recordings[static_cast<std::size_t>(splits.front().tests[i])], *base, {}, 0));

  SpeedRow("search alone", tests, [&] {
    return [model, found = std::vector<Neighbour>()](const Eigen::VectorXd& reading) mutable {
      model->search().Nearest(model->scale().cwiseProduct(reading.cast<float>()), 4096, &found);
    };
  });
  const auto of = [&](OlngPose pose) {
    const auto with = std::make_shared<OlngModel>(base, WithPose(options, pose));
    return [with] {
      const auto estimator = std::make_shared<OlngEstimator>(with);
      return [estimator](const Eigen::VectorXd& reading) { estimator->Next(reading); };
    };
  };
  SpeedRow("search, graph, weighted mean", tests, of(OlngPose::kWeightedMean));
  SpeedRow("whole step", tests, of(OlngPose::kEnergy));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("most memory of the whole program, making the base included: %.2f GB\n", static_cast<double>(usage.ru_maxrss) * 1024 / 1e9);
}

// Values of options, tried one at a time about the defaults.
void Sweep(Study& study, const OlngOptions& defaults, const std::vector<std::string>& settings, const Trial& trial) {
  PrintHead("settings");
  const double nearest = study.Nearest(trial).mean();
  for (const std::string& setting : settings) {
    OlngOptions options = defaults;
    std::size_t from = 0;
    while (from < setting.size()) {
      const std::size_t to = std::min(setting.find(',', from), setting.size());
      const std::string part = setting.substr(from, to - from);
      from = to + 1;
      const std::size_t equals = part.find('=');
      const std::string name = part.substr(0, equals);
      const double value = equals == std::string::npos ? 0 : std::stod(part.substr(equals + 1));
      const std::map<std::string, std::function<void()>> known = {
          {"K", [&] { options.neighbours = static_cast<int>(value); }},
          {"I", [&] { options.paths = static_cast<int>(value); }},
          {"M", [&] { options.graph.window_frames = static_cast<int>(value); }},
          {"step", [&] { options.graph.step_penalty = value; }},
          {"miss", [&] { options.graph.miss_penalty = value; }},
          {"exponent", [&] { options.sensor_exponent = value; }},
          {"mean", [&] { options.pose = OlngPose::kWeightedMean; }},
          {"prior", [&] { options.energy.kind = static_cast<PriorKind>(static_cast<int>(value)); }},
          {"wcontrol", [&] { options.energy.control = value; }},
          {"wpose", [&] { options.energy.pose = value; }},
          {"wmotion", [&] { options.energy.motion = value; }},
          {"wsmooth", [&] { options.energy.smooth = value; }},
          {"kept", [&] { options.energy.kept_variance = value; }},
          {"softrad", [&] { options.energy.softening_rad = value; }},
          {"softm", [&] { options.energy.softening_m = value; }},
          {"ridgerad", [&] { options.energy.ridge_rad = value; }},
          {"ridgem", [&] { options.energy.ridge_m = value; }},
          {"squared", [&] { options.energy.squared = value != 0; }},
          {"least", [&] { options.energy.least_acceleration_m = value; }},
          {"iterations", [&] { options.energy.max_iterations = static_cast<int>(value); }}};
      if (!known.count(name)) throw std::invalid_argument("unknown setting '" + name + "'");
      known.at(name)();
    }
    const double start = ThreadSeconds();
    const Outcome outcome = study.Try(options, trial);
    Print(setting + " [" + std::to_string(1e3 * (ThreadSeconds() - start) / static_cast<double>(outcome.frames)).substr(0, 4) + " ms]", outcome, nearest);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Motion from a few accelerometers: errors and cost.");
  std::vector<std::filesystem::path> data;
  std::string split = "clip";
  std::vector<std::string> rows = {"plain"}, sweep, only;
  bool tune = false, faulty = false, each = false;
  int folds = 0;
  double tempo = 1;
  std::vector<double> tempos(std::begin(kOlngTempos), std::end(kOlngTempos));
  bool no_tempos = false;
  long long speed = 0;
  std::filesystem::path out;
  app.add_option("--data", data, "folders of BVH")->required();
  app.add_option("--split", split, "what is left out of the base: clip, style or folder")->check(CLI::IsMember({"clip", "style", "folder"}));
  app.add_option("--rows", rows, "tables: plain, priors, faults, tempo, body, sensors, reversed");
  app.add_flag("--tune", tune, "the clips on which defaults are chosen");
  app.add_option("--sweep", sweep, "settings to try, such as K=512,I=32");
  app.add_flag("--faulty", faulty, "with --sweep: noisy sensors that are mounted askew");
  app.add_option("--tempo", tempo, "with --sweep: play the test clips this many times as fast");
  app.add_option("--tempos", tempos, "more copies in the base, this many times as fast");
  app.add_flag("--no-tempos", no_tempos, "none of these");
  app.add_option("--speed", speed, "time a frame on a base of this many frames");
  app.add_option("--only", only, "test clips of these folders only, such as 07 08");
  app.add_option("--folds", folds, "try every clip: this many bases, each without its part of the clips")->check(CLI::Range(2, 1000))->excludes("--split")->excludes("--tune")->excludes("--only")->excludes("--rows");
  app.add_flag("--each", each, "a line a test clip as well");
  app.add_option("--out", out, "a folder for what is made of the test clips, and the truth, as BVH");
  CLI11_PARSE(app, argc, argv);
  try {
    const std::vector<Recording> recordings = Load(data);
    const OlngOptions options;
    if (speed > 0) {
      Speed(recordings, options, speed);
      return 0;
    }
    if (no_tempos) tempos.clear();
    Study study(recordings, folds > 0 ? MakeFolds(recordings, folds) : MakeSplits(recordings, split, tune, only), tempos, out, each);
    study.UseBases(kFour, {});
    study.Describe();
    if (!sweep.empty()) {
      Trial trial;
      trial.tempo = tempo;
      if (faulty) trial.faults = BadSensors();
      Sweep(study, options, sweep, trial);
      return 0;
    }
    if (folds > 0) {
      FoldRows(study, options);
      return 0;
    }
    for (const std::string& row : rows) {
      if (row == "plain") {
        PlainRows(study, options);
      } else if (row == "priors") {
        PriorRows(study, options);
      } else if (row == "faults") {
        SensorFaults noise = BadSensors(), mounting = BadSensors();
        const SensorFaults both = BadSensors();
        noise.mounting_rad = 0;
        mounting.noise = 0;
        TrialRows(study, options, "faults", {{"none", {}}, {"noise 1.2 m/s^2 per axis", {1, 1, noise}}, {"mounting error 10 degrees", {1, 1, mounting}}, {"both", {1, 1, both}}});
      } else if (row == "tempo") {
        TrialRows(study, options, "tempo", {{"0.8", {.tempo = 0.8, .faults = {}}}, {"0.9", {.tempo = 0.9, .faults = {}}}, {"1.1", {.tempo = 1.1, .faults = {}}}, {"1.2", {.tempo = 1.2, .faults = {}}}});
      } else if (row == "body") {
        TrialRows(study, options, "body's lengths", {{"0.8", {.size = 0.8, .faults = {}}}, {"0.9", {.size = 0.9, .faults = {}}}, {"1.1", {.size = 1.1, .faults = {}}}, {"1.2", {.size = 1.2, .faults = {}}}});
      } else if (row == "sensors") {
        SensorRows(study, options);
      } else if (row == "reversed") {
        MotionBaseOptions reversed;
        reversed.time_reversed = true;
        study.UseBases(kFour, reversed);
        std::printf("\nwith copies backwards in time:");
        PlainRows(study, options);
        study.UseBases(kFour, {});
      } else {
        throw std::invalid_argument("unknown row '" + row + "'");
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sensor_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
