#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/placements.h"
#include "datasets/readings.h"
#include "graph/motion_graph.h"
#include "synthesis/sensors/pose_estimator.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "synthesis/sensors/sensor_steps.h"
#include "synthesis/sensors/worn_sensors.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// Readings go into every method, and poses come out, at this rate.
inline constexpr double kReconstructionRate_hz = 30;

/// How motion is found again from readings (METHODS section 5).
enum class ReconstructionMethod {
  kGraph,     // a walk over the motion graph; needs the whole stream
  kOlng,      // online lazy neighbourhood graph (Tautges 2011), poses by regularised normal distributions
  kOlngKernels,  // the same, poses by square-root kernels, as published
  kRbf,       // radial basis functions (Xie 2009, 6.1), poses by principal components
  kRbfLle,    // the same, poses by locally linear embedding (Xie 2009, 5.1.3)
  kGaussian,  // local Gaussians, optimised (Xie 2009, 6.2)
  kMarkers,   // local linear maps and a forest (Liu 2006); takes marker positions, the others accelerations
};
inline constexpr ReconstructionMethod kReconstructionMethods[] = {ReconstructionMethod::kGraph, ReconstructionMethod::kOlng, ReconstructionMethod::kOlngKernels,
                                                                  ReconstructionMethod::kRbf,   ReconstructionMethod::kRbfLle,   ReconstructionMethod::kGaussian,
                                                                  ReconstructionMethod::kMarkers};
std::string_view MethodName(ReconstructionMethod method);  // "graph", "olng", …
std::optional<ReconstructionMethod> ParseMethod(std::string_view name);

/// A reconstructed clip and what is to be said of it.
struct Reconstruction {
  MotionClip clip;          // from the origin facing +Z, at kReconstructionRate_hz
  SynthesisReport report;   // steps and likelihood with kGraph alone
  std::optional<double> residual_m_s2;  // of kGraph: root mean square of readings less the walk's
  double latency_ms_mean = 0, latency_ms_p95 = 0;  // of a frame; kGraph, kOlng and kOlngKernels: its share of the whole, both alike
};

/// What one method learned for sensors at given places. Immutable: streams may share it. Made from the recordings that the model keeps; where it keeps none, from
/// walks that it makes itself, which reconstructs less well.
class Reconstructor {
 public:
  virtual ~Reconstructor() = default;
  ReconstructionMethod method() const { return method_; }
  const std::vector<Placement>& sensors() const { return sensors_; }
  /// What sensors in these places read on somebody who stands. Empty with kMarkers.
  const WornSensors& worn() const { return worn_; }
  /// @param readings  (3 * sensors x frames) at kReconstructionRate_hz, finite: accelerations as MotionBase::accelerations(), or positions of markers.
  /// kOlng and kOlngKernels look ahead as well as back (ReconstructRecording()) and so come nearer than streams; the others but kGraph make of it what a stream of them would.
  /// @throws std::invalid_argument for readings that are too short (kGraph: a step; others: one frame) or of other sensors.
  virtual Reconstruction Run(const Eigen::MatrixXd& readings) const = 0;
  /// One stream, a frame in, a frame out. Null for kGraph.
  virtual std::unique_ptr<PoseEstimator> Start() const = 0;
  /// What poses of streams refer to. Null for kGraph.
  virtual const MotionBase* base() const = 0;
  /// What clips are steered by readings with (SensorGuide). Of kGraph alone.
  virtual std::shared_ptr<const SensorSteps> steps() const { return nullptr; }

 protected:
  Reconstructor(ReconstructionMethod method, std::vector<Placement> sensors, WornSensors worn) : method_(method), sensors_(std::move(sensors)), worn_(std::move(worn)) {}

 private:
  ReconstructionMethod method_;
  std::vector<Placement> sensors_;
  WornSensors worn_;
};

/// @throws UnsatisfiableRequest ("/sensors/placements/2/joint", …) where a joint does not exist, or a marker's place is not known.
std::shared_ptr<const Reconstructor> MakeReconstructor(std::shared_ptr<const MotionGraph> graph, ReconstructionMethod method, std::vector<Placement> sensors, int jobs = 1);

/// Where sensors of these names sit: those of `placements` where there are any of that name, else joints called so and, of markers, those of FullBodyMarkers().
/// @throws UnsatisfiableRequest naming a sensor that cannot be placed.
std::vector<Placement> PlacesOf(const std::vector<std::string>& sensors, const std::vector<Placement>& placements, const MotionGraph& graph,
                                ReconstructionMethod method);

/// Compares a reconstruction with the true motion, frame by frame from the beginning as far as both go.
/// @throws std::invalid_argument where the truth's skeleton cannot be put on the model's, or fewer than 4 frames are common.
ReconstructionQuality CompareClips(const MotionClip& reconstructed, const MotionClip& truth);

}  // namespace morphograph
