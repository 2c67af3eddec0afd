#include "synthesis/sensors/reconstruction.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <type_traits>

#include "datasets/marker_set.h"
#include "datasets/quantile.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "synthesis/evaluation.h"
#include "synthesis/sensors/gaussian_estimator.h"
#include "synthesis/sensors/graph_reconstruction.h"
#include "synthesis/sensors/marker_estimator.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/olng_estimator.h"
#include "synthesis/sensors/olng_recording.h"
#include "synthesis/sensors/rbf_estimator.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

class GraphReconstructor : public Reconstructor {
 public:
  GraphReconstructor(std::shared_ptr<const MotionGraph> graph, const MotionSource& source, std::vector<Placement> sensors, int jobs)
      : Reconstructor(ReconstructionMethod::kGraph, sensors, WornBy(source.clips, sensors)),
        graph_(std::move(graph)),
        steps_(std::make_shared<const SensorSteps>(source.clips, source.steps, graph_->layout(), std::move(sensors), jobs)) {}

  Reconstruction Run(const Eigen::MatrixXd& readings) const override {
    const Clock::time_point start = Clock::now();
    GraphReconstruction walk = ReconstructWalk(*graph_, *steps_, readings);
    Reconstruction reconstruction;
    reconstruction.latency_ms_mean = reconstruction.latency_ms_p95 = MillisecondsSince(start) / static_cast<double>(readings.cols());
    reconstruction.clip = std::move(walk.result.clip);
    reconstruction.report = std::move(walk.result.report);
    reconstruction.residual_m_s2 = walk.residual_m_s2;
    return reconstruction;
  }
  std::unique_ptr<PoseEstimator> Start() const override { return nullptr; }
  const MotionBase* base() const override { return nullptr; }
  std::shared_ptr<const SensorSteps> steps() const override { return steps_; }

 private:
  std::shared_ptr<const MotionGraph> graph_;
  std::shared_ptr<const SensorSteps> steps_;
};

SynthesisReport DescribeClip(const MotionGraph& graph, const MotionClip& clip) {
  SynthesisReport report;
  report.model_name = graph.name();
  report.model_hash = graph.hash();
  report.frames = clip.frame_count();
  report.duration_s = clip.duration_s();
  for (int f = 0; f < clip.frame_count(); ++f) report.path_m.emplace_back(clip.root_positions()(0, f), clip.root_positions()(2, f));
  if (clip.frame_count() >= 2) {
    const ClipEvaluation evaluation = EvaluateClip(clip);
    report.contacts = evaluation.contacts;
    report.quality = evaluation.quality;
  }
  return report;
}

// Methods that go frame by frame, but for whole recordings of olng, of which the future is known.
template <typename Model, typename Estimator>
class StreamReconstructor : public Reconstructor {
 public:
  StreamReconstructor(std::shared_ptr<const MotionGraph> graph, ReconstructionMethod method, std::vector<Placement> sensors, WornSensors worn,
                      std::shared_ptr<const MotionBase> base, std::shared_ptr<const Model> model)
      : Reconstructor(method, std::move(sensors), std::move(worn)), graph_(std::move(graph)), base_(std::move(base)), model_(std::move(model)) {}

  Reconstruction Run(const Eigen::MatrixXd& readings) const override {
    if (readings.cols() == 0) throw std::invalid_argument("Reconstructor: no readings");
    std::vector<BasePose> poses;
    std::vector<double> times_ms;
    const auto timed = [&](const auto& work) {
      const Clock::time_point start = Clock::now();
      work();
      return MillisecondsSince(start);
    };
    if constexpr (std::is_same_v<Estimator, OlngEstimator>) {
      times_ms.push_back(timed([&] { poses = ReconstructRecording(model_, readings); }) / static_cast<double>(readings.cols()));
    } else {
      const std::unique_ptr<PoseEstimator> stream = Start();
      for (Eigen::Index f = 0; f < readings.cols(); ++f) times_ms.push_back(timed([&] { poses.push_back(stream->Next(readings.col(f))); }));
    }
    Reconstruction reconstruction;
    for (const double time_ms : times_ms) reconstruction.latency_ms_mean += time_ms / static_cast<double>(times_ms.size());
    reconstruction.latency_ms_p95 = Quantile(times_ms, 0.95);
    reconstruction.clip = base_->Assemble(poses);
    reconstruction.report = DescribeClip(*graph_, reconstruction.clip);
    return reconstruction;
  }
  std::unique_ptr<PoseEstimator> Start() const override { return std::make_unique<Estimator>(model_); }
  const MotionBase* base() const override { return base_.get(); }

 private:
  std::shared_ptr<const MotionGraph> graph_;
  std::shared_ptr<const MotionBase> base_;
  std::shared_ptr<const Model> model_;
};

template <typename Estimator, typename Model>
std::shared_ptr<const Reconstructor> MakeStreams(const std::shared_ptr<const MotionGraph>& graph, ReconstructionMethod method, std::vector<Placement> sensors, WornSensors worn,
                                                 std::shared_ptr<const MotionBase> base, std::shared_ptr<const Model> model) {
  return std::make_shared<StreamReconstructor<Model, Estimator>>(graph, method, std::move(sensors), std::move(worn), std::move(base), std::move(model));
}

}  // namespace

std::string_view MethodName(ReconstructionMethod method) {
  switch (method) {
    case ReconstructionMethod::kGraph: return "graph";
    case ReconstructionMethod::kOlng: return "olng";
    case ReconstructionMethod::kOlngKernels: return "olng_kernels";
    case ReconstructionMethod::kRbf: return "rbf";
    case ReconstructionMethod::kRbfLle: return "rbf_lle";
    case ReconstructionMethod::kGaussian: return "gaussian";
    case ReconstructionMethod::kMarkers: return "markers";
  }
  throw std::logic_error("MethodName: no such method");
}

std::optional<ReconstructionMethod> ParseMethod(std::string_view name) {
  for (const ReconstructionMethod method : kReconstructionMethods) {
    if (MethodName(method) == name) return method;
  }
  return std::nullopt;
}

static_assert(kReconstructionRate_hz == kSensorRate_hz);

std::shared_ptr<const Reconstructor> MakeReconstructor(std::shared_ptr<const MotionGraph> graph, ReconstructionMethod method, std::vector<Placement> sensors, int jobs) {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const int joint = graph->skeleton().FindRoleOrName(sensors[i].joint);
    if (joint < 0 || !graph->skeleton().IsBody(joint))
      throw UnsatisfiableRequest("/sensors/placements/" + std::to_string(i) + "/joint", "the model's skeleton has no joint '" + sensors[i].joint + "' that moves");
  }
  if (sensors.empty()) throw UnsatisfiableRequest("/sensors/placements", "no sensor is left to reconstruct from");
  const MotionSource source = SourceOf(*graph, jobs);
  if (method == ReconstructionMethod::kGraph) return std::make_shared<GraphReconstructor>(graph, source, std::move(sensors), jobs);
  MotionBaseOptions options;
  options.frame_rate_hz = kReconstructionRate_hz;
  options.jobs = jobs;
  if (method == ReconstructionMethod::kOlng || method == ReconstructionMethod::kOlngKernels) options.tempos.assign(std::begin(kOlngTempos), std::end(kOlngTempos));
  const bool markers = method == ReconstructionMethod::kMarkers;
  WornSensors worn;
  if (!markers) worn = WornBy(source.clips, sensors);
  const auto base = std::make_shared<const MotionBase>(source.clips, markers ? std::vector<Placement>() : sensors, options);
  switch (method) {
    case ReconstructionMethod::kRbf:
    case ReconstructionMethod::kRbfLle: {
      RbfOptions rbf;
      if (method == ReconstructionMethod::kRbfLle) rbf.reduction.kind = ReductionKind::kLle;
      rbf.jobs = jobs;
      return MakeStreams<RbfEstimator>(graph, method, std::move(sensors), std::move(worn), base, std::make_shared<const RbfModel>(*base, rbf));
    }
    case ReconstructionMethod::kGaussian: {
      GaussianOptions gaussian;
      gaussian.jobs = jobs;
      return MakeStreams<GaussianEstimator>(graph, method, std::move(sensors), std::move(worn), base, std::make_shared<const GaussianModel>(*base, gaussian));
    }
    case ReconstructionMethod::kMarkers: {
      MarkerOptions given;
      given.jobs = jobs;
      std::vector<Placement> all = FullBodyMarkers(source.clips);
      for (const Placement& sensor : sensors) {
        given.given.push_back(sensor.name);
        std::erase_if(all, [&](const Placement& marker) { return marker.name == sensor.name; });
        all.push_back(sensor);
      }
      return MakeStreams<MarkerEstimator>(graph, method, std::move(sensors), std::move(worn), base, std::make_shared<const MarkerModel>(*base, all, given));
    }
    default: {
      OlngOptions olng_options;
      if (method == ReconstructionMethod::kOlngKernels) olng_options.energy.kind = PriorKind::kKernel;
      return MakeStreams<OlngEstimator>(graph, method, std::move(sensors), std::move(worn), base, std::make_shared<const OlngModel>(base, olng_options));
    }
  }
}

std::vector<Placement> PlacesOf(const std::vector<std::string>& sensors, const std::vector<Placement>& placements, const MotionGraph& graph,
                                ReconstructionMethod method) {
  std::vector<Placement> known = placements;
  if (method == ReconstructionMethod::kMarkers && known.empty()) known = FullBodyMarkers(SourceOf(graph).clips);
  std::vector<Placement> places;
  for (const std::string& name : sensors) {
    const auto place = std::find_if(known.begin(), known.end(), [&](const Placement& placement) { return placement.name == name; });
    if (place != known.end()) {
      places.push_back(*place);
    } else if (const int joint = graph.skeleton().FindRoleOrName(name); joint >= 0 && graph.skeleton().IsBody(joint)) {
      places.push_back({name, name});
    } else {
      throw UnsatisfiableRequest("/sensors/placements", "where sensor '" + name + "' sits is not known: it is no joint of the model's skeleton and no placement says it");
    }
  }
  return places;
}

ReconstructionQuality CompareClips(const MotionClip& reconstructed, const MotionClip& truth) {
  MotionClip there = truth;
  if (there.shared_skeleton() != reconstructed.shared_skeleton()) there = Retarget(there, reconstructed.shared_skeleton());
  there = Resample(there, reconstructed.frame_rate_hz());
  const int frames = std::min(there.frame_count(), reconstructed.frame_count());
  if (frames < 5) throw std::invalid_argument("CompareClips: fewer than 5 frames in common");
  there = there.Slice(0, frames);
  const MotionClip here = reconstructed.Slice(0, frames);
  MotionBaseOptions options;
  options.frame_rate_hz = reconstructed.frame_rate_hz();
  options.mirrored = false;
  const MotionBase base({there}, {}, options);
  return CompareWithTruth(base, PosesOf(base, here), there);
}

}  // namespace morphograph
