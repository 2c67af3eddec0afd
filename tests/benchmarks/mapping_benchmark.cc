// Poses from a few accelerometers by maps learned from recordings (Xie 2009): errors beside the nearest neighbour's, and times.
//
//   mapping_benchmark --data RECORDINGS [--tune] [--splits known,unseen,cmu] [--rows rbf,gaussian,rbf-lle] [options of the methods]
//   mapping_benchmark --data RECORDINGS --fair                     LLE and PCA in rbf, each with the settings that are best on clips left out of the training set
//
// RECORDINGS holds bnr/ and cmu/. Which clips are tested: recordings.h. Readings are those of a test clip's own body; errors are of the joints
// in the pelvis frame, per frame.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>

#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/gaussian_estimator.h"
#include "synthesis/sensors/rbf_estimator.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/benchmarks/recordings.h"

namespace {

using namespace morphograph;
using Clock = std::chrono::steady_clock;

// Two a limb, as Xie's were on arms and legs.
const std::vector<std::string> kXieJoints = {"left_elbow", "left_wrist", "right_elbow", "right_wrist",
                                             "left_knee",  "left_ankle", "right_knee",  "right_ankle"};

// The pose whose readings are nearest, frame by frame.
class NearestNeighbour : public PoseEstimator {
 public:
  explicit NearestNeighbour(const MotionBase& base) : base_(base) {}
  BasePose Next(const Eigen::VectorXd& reading) override {
    const Eigen::VectorXf values = reading.cast<float>();
    Eigen::Index nearest = 0;
    (base_.accelerations().colwise() - values).colwise().squaredNorm().minCoeff(&nearest);
    return base_.Pose(nearest);
  }

 private:
  const MotionBase& base_;
};

struct Row {
  double rms = 0, p95 = 0, velocity = 0, jerk = 0, normalised = 0, angle = 0, microseconds = 0;
  long long frames = 0;
};

double Seconds(Clock::time_point from) { return std::chrono::duration<double>(Clock::now() - from).count(); }

// Of this thread alone: other work on the machine does not count.
double ProcessorTime_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

void Add(const MotionBase& base, const Split& split, const std::function<std::unique_ptr<PoseEstimator>()>& make, Row* row) {
  for (const Recording& recording : split.unseen) {
    const Readings readings = VirtualAccelerations(recording.own, base.sensors(), base.frame_rate_hz());
    const auto estimator = make();
    std::vector<BasePose> poses;
    const double start = ProcessorTime_us();
    for (int f = 0; f < recording.own.frame_count(); ++f) poses.push_back(estimator->Next(readings.values.col(f)));
    row->microseconds += ProcessorTime_us() - start;
    const ReconstructionQuality q = CompareWithTruth(base, poses, recording.common);
    const double n = q.frames;
    row->frames += q.frames;
    row->rms += n * q.position_rms_cm;
    row->p95 += n * q.position_rms_p95_cm;
    row->velocity += n * q.velocity_error_cm_s;
    row->jerk += n * q.jerk_ratio;
    row->normalised += n * q.normalised_rms;
    row->angle += n * q.angle_deg;
  }
}

void Print(const std::string& name, const Row& row, const Row& nearest) {
  const auto n = static_cast<double>(row.frames);
  std::printf("  %-26s %6.2f %6.2f %6.3f %8.1f %6.2f %7.3f %6.2f %8.1f\n", name.c_str(), row.rms / n, row.p95 / n, row.rms / nearest.rms, row.velocity / n,
              row.jerk / n, row.normalised / n, row.angle / n, row.microseconds / n);
  std::fflush(stdout);
}

struct Method {
  std::string name;
  /// Learns, and says how to begin a stream.
  std::function<std::function<std::unique_ptr<PoseEstimator>()>(const MotionBase&)> learn;
};

using MakeMethod = std::function<Method(const std::string&, const RbfOptions&)>;

std::string NameOf(const RbfOptions& with) {
  char name[80];
  if (with.reduction.kind == ReductionKind::kLle) std::snprintf(name, sizeof name, "LLE, %d neighbours, %g", with.reduction.neighbours, with.reduction.regularisation);
  else std::snprintf(name, sizeof name, "PCA, ridge %g, width %.3g", with.map.ridge, with.map.width);
  return name;
}

// A value that is tuned, and the least and greatest that are tried.
struct Knob {
  std::function<double(const RbfOptions&)> get;
  std::function<void(RbfOptions*, double)> set;
  double factor, least, greatest;
};

// Two for each reduction.
std::vector<Knob> KnobsOf(ReductionKind kind) {
  if (kind == ReductionKind::kLle) {
    return {{[](const RbfOptions& o) { return o.reduction.regularisation; }, [](RbfOptions* o, double v) { o->reduction.regularisation = v; }, 10, 1e-6, 1e3},
            {[](const RbfOptions& o) { return o.reduction.neighbours; }, [](RbfOptions* o, double v) { o->reduction.neighbours = static_cast<int>(v); }, 2, 6, 768}};
  }
  return {{[](const RbfOptions& o) { return o.map.ridge; }, [](RbfOptions* o, double v) { o->map.ridge = v; }, 10, 1e-9, 1e3},
          {[](const RbfOptions& o) { return o.map.width; }, [](RbfOptions* o, double v) { o->map.width = v; }, 1.5, 0.2, 50}};
}

// Settings that no change of one value by its factor betters by a 500th, found by changing one after the other for as long as that helps.
RbfOptions Tuned(RbfOptions best, const std::function<double(const RbfOptions&)>& error_of) {
  constexpr double kGain = 0.998;  // less is not worth going on for
  double least = error_of(best);
  const auto betters = [&](const Knob& knob, double factor) {
    RbfOptions tried = best;
    knob.set(&tried, knob.get(best) * factor);
    const double value = knob.get(tried);
    if (value < knob.least || value > knob.greatest) return false;
    const double error = error_of(tried);
    if (!(error < kGain * least)) return false;
    least = error, best = tried;
    return true;
  };
  for (bool moved = true; moved;) {
    moved = false;
    for (const Knob& knob : KnobsOf(best.reduction.kind)) {
      for (const double factor : {knob.factor, 1 / knob.factor}) {
        bool went = false;
        while (betters(knob, factor)) went = true;
        moved = moved || went;
        if (went) break;  // the other way leads back
      }
    }
  }
  return best;
}

// Tunes both reductions, with seven coordinates as published, on every 15th clip of the training set, left out of it, and tries the best of each on the test clips.
void CompareFairly(const Split& split, const RbfOptions& defaults, const MakeMethod& method, const MotionBaseOptions& base_options) {
  constexpr std::size_t kStep = 15;
  Split inner{"tuning", {}, {}};
  for (std::size_t i = 0; i < split.base.size(); ++i) {
    if (i % kStep == kStep / 2) inner.unseen.push_back({split.base[i], split.base[i], {}});
    else inner.base.push_back(split.base[i]);
  }
  const MotionBase inner_base(inner.base, PlacementsAtJoints(kXieJoints), base_options), base(split.base, PlacementsAtJoints(kXieJoints), base_options);
  Row nearest;
  Add(base, split, [&] { return std::make_unique<NearestNeighbour>(base); }, &nearest);
  std::printf("error, cm, on %zu clips left out of the training set\n", inner.unseen.size());
  for (const ReductionKind kind : {ReductionKind::kLle, ReductionKind::kPca}) {
    RbfOptions start = defaults;
    start.reduction.kind = kind;
    start.reduction.components = 7;
    const RbfOptions best = Tuned(start, [&](const RbfOptions& tried) {
      Row row;
      Add(inner_base, inner, method(NameOf(tried), tried).learn(inner_base), &row);
      const double error = row.rms / static_cast<double>(row.frames);
      std::printf("  %-30s %6.2f, jerk %.2f\n", NameOf(tried).c_str(), error, row.jerk / static_cast<double>(row.frames));
      std::fflush(stdout);
      return error;
    });
    Row row;
    Add(base, split, method(NameOf(best), best).learn(base), &row);
    std::printf("the best on the test clips: RMS cm, p95, part of the nearest neighbour's, cm/s, jerk x, Eq. 7.1, deg, us/frame\n");
    Print(NameOf(best), row, nearest);
  }
}

void Run(const std::string& title, const std::vector<Split>& splits, const std::vector<Method>& methods, const MotionBaseOptions& options) {
  std::vector<Row> rows(methods.size());
  Row nearest;
  for (const Split& split : splits) {
    const MotionBase base(split.base, PlacementsAtJoints(kXieJoints), options);
    Add(base, split, [&] { return std::make_unique<NearestNeighbour>(base); }, &nearest);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const auto start = Clock::now();
      const auto make = methods[m].learn(base);
      std::fprintf(stderr, "%s, %s: %lld frames, learned in %.1f s\n", split.name.c_str(), methods[m].name.c_str(), static_cast<long long>(base.frame_count()),
                   Seconds(start));
      Add(base, split, make, &rows[m]);
    }
  }
  std::printf("%s, %lld frames tested\n  %-26s %6s %6s %6s %8s %6s %7s %6s %8s\n", title.c_str(), nearest.frames, "method", "RMS cm", "p95", "/ NN", "cm/s", "jerk",
              "Eq.7.1", "deg", "us/frame");
  Print("nearest neighbour", nearest, nearest);
  for (std::size_t m = 0; m < methods.size(); ++m) Print(methods[m].name, rows[m], nearest);
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path data;
  bool tune = false, fair = false, no_mirror = false;
  std::vector<std::string> splits = {"known", "unseen", "cmu"};
  std::vector<std::string> wanted = {"rbf", "rbf-raw"};
  RbfOptions rbf;
  GaussianOptions gaussian;
  CLI::App app("Poses from accelerometers by learned maps");
  app.add_option("--data", data, "folder with bnr and cmu")->required();
  app.add_flag("--tune", tune, "the clips to tune on, not those to test on");
  app.add_option("--splits", splits, "known, unseen, cmu: which of them")->delimiter(',');
  app.add_flag("--fair", fair, "locally linear embedding and principal components, seven coordinates, both tuned on clips of the training set, then tried on known styles");
  app.add_flag("--no-mirror", no_mirror, "no mirrored copies in the base");
  app.add_option("--rows", wanted, "methods")->delimiter(',');
  app.add_option("--components", rbf.reduction.components, "of a pose");
  app.add_option("--neighbours", rbf.reduction.neighbours, "of a pose, in locally linear embedding (rbf-lle)");
  app.add_option("--regularisation", rbf.reduction.regularisation, "of their weights");
  app.add_option("--embedded", rbf.reduction.samples, "poses that are embedded; others are placed by them");
  app.add_option("--max-clusters", rbf.clusters.max_clusters, "of poses");
  app.add_option("--cluster-components", rbf.clusters.components, "of a pose, in clusters");
  app.add_option("--centres", rbf.map.centres, "of a map");
  app.add_option("--width", rbf.map.width, "of a centre");
  app.add_option("--ridge", rbf.map.ridge, "of a map");
  app.add_option("--evidence", rbf.evidence, "of a reading");
  app.add_option("--window", rbf.window, "frames");
  app.add_option("--g-components", gaussian.reduction.components, "of a pose, gaussian");
  app.add_option("--g-centres", gaussian.map.centres, "of a map, gaussian");
  app.add_option("--g-evidence", gaussian.evidence, "of a reading, gaussian");
  app.add_option("--g-readings", gaussian.control_readings, "compared");
  app.add_option("--g-stride", gaussian.control_stride, "frames between them");
  app.add_option("--g-damping", gaussian.damping, "of the motion carried on");
  app.add_option("--g-smoothness", gaussian.smoothness_weight, "weight");
  app.add_option("--g-control", gaussian.control_weight, "weight");
  app.add_option("--g-iterations", gaussian.max_iterations, "at most");
  app.add_option("--g-surprise", gaussian.surprise_s, "seconds over which readings' errors are watched");
  app.add_option("--g-control-power", gaussian.surprise_control_power, "of what is then found");
  app.add_option("--g-evidence-power", gaussian.surprise_evidence_power, "the same, for clusters");
  app.add_option("--g-activity-power", gaussian.activity_power, "of how quick the motion is, in the unit of smoothness");
  app.add_option("--g-unit", gaussian.smoothness_unit, "of smoothness");
  app.add_option("--g-ridge", gaussian.map.ridge, "of a map, gaussian");
  app.add_option("--g-ridge-samples", gaussian.map.ridge_samples, "the same, over the number of samples");
  app.add_option("--fit-frames", rbf.clusters.fit_frames, "frames of clusters");
  CLI11_PARSE(app, argc, argv);
  rbf.jobs = gaussian.jobs = 2;
  gaussian.clusters = rbf.clusters;

  const auto rbf_method = [](const std::string& name, const RbfOptions& options) {
    return Method{name, [options](const MotionBase& base) {
                    auto model = std::make_shared<const RbfModel>(base, options);
                    for (const auto& tried : model->clusters.candidates) std::fprintf(stderr, "%d clusters: %.0f\n", tried.clusters, tried.description_length);
                    return [model]() -> std::unique_ptr<PoseEstimator> { return std::make_unique<RbfEstimator>(model); };
                  }};
  };
  const auto gaussian_method = [](const std::string& name, const GaussianOptions& options) {
    return Method{name, [options](const MotionBase& base) {
                    auto model = std::make_shared<const GaussianModel>(base, options);
                    return [model]() -> std::unique_ptr<PoseEstimator> { return std::make_unique<GaussianEstimator>(model); };
                  }};
  };
  std::vector<Method> methods;
  for (const std::string& name : wanted) {
    RbfOptions options = rbf;
    if (name == "gaussian") methods.push_back(gaussian_method(name, gaussian));
    if (name == "rbf") methods.push_back(rbf_method(name, options));
    if (name == "rbf-raw") options.window = 1, methods.push_back(rbf_method("rbf without window", options));
    if (name == "rbf-xie") options.choice = ClusterChoice::kNearestMean, methods.push_back(rbf_method("rbf, nearest cluster", options));
    if (name == "rbf-lle") options.reduction.kind = ReductionKind::kLle, methods.push_back(rbf_method("rbf, LLE", options));
  }
  const Purpose purpose = tune ? Purpose::kTune : Purpose::kTest;
  MotionBaseOptions base;
  base.mirrored = !no_mirror;
  base.jobs = 2;
  const auto bnr = LoadRecordings(data / "bnr/dataset-2", {"walk", "walk-turn-left", "walk-turn-right"}, base.frame_rate_hz, false);
  const auto wants = [&](const char* split) { return std::find(splits.begin(), splits.end(), split) != splits.end(); };
  if (fair) {
    base.mirrored = false;
    CompareFairly(KnownStyle(bnr, Purpose::kTest), rbf, rbf_method, base);
    return 0;
  }
  if (wants("known")) Run("bnr, known style", {KnownStyle(bnr, purpose)}, methods, base);
  if (wants("unseen")) Run("bnr, unseen style", UnseenGroups(bnr, 20, purpose), methods, base);
  if (!wants("cmu")) return 0;
  const auto cmu = LoadRecordings(data / "cmu", {"07", "08"}, base.frame_rate_hz, true);
  Run("cmu, unseen subject", UnseenGroups(cmu, 2, purpose), methods, base);
}
