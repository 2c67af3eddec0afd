#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <vector>

#include "graph/motion_graph.h"
#include "synthesis/control/sensor_guide.h"
#include "synthesis/swept_area.h"
#include "synthesis/synthesis_types.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {

/// One clip of many that were made for one request.
struct ClipVariant {
  int index = 0;  // its seed is the request's, plus this
  MotionClip clip;
  SynthesisReport report;
  double log_likelihood_per_step = 0;
};

struct MeasuredRange {
  double min = 0;
  double mean = 0;
  double max = 0;
};

/// What the variants of a request have in common, and how far they lie apart.
struct VariantSummary {
  int asked = 0;
  int made = 0;
  MeasuredRange duration_s;
  /// When the root comes within the goal's tolerance for good; of the path's end, where there is no goal. Empty without either.
  std::optional<MeasuredRange> arrival_s;
  /// Distance of the root from the path over all frames of all variants. Empty without a path.
  std::optional<double> path_deviation_mean_m, path_deviation_max_m;
  /// MeanPairwiseJointDistance() of whole clips in the world at 20 phases, and of their steps in the body's frame at 10 phases: steps of the
  /// same primitive against each other, at most 200 of each, evenly picked by rank.
  double clip_spread_m = 0;
  double step_spread_m = 0;
  SweptArea swept_area;
};

struct VariantSet {
  std::vector<ClipVariant> variants;  // by likelihood per step, the likeliest first; equals by index
  VariantSummary summary;
};

/// More than may be held at a time was asked for.
class VariantsTooLarge : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller asked to stop.
class VariantsCancelled : public std::runtime_error {
 public:
  VariantsCancelled() : std::runtime_error("cancelled") {}
};

struct VariantOptions {
  int count = 1;    // clips, with the request's seed, the next one (after 2^64 - 1 comes 0), ...
  int threads = 1;
  /// Joints times frames of all clips together, each about 32 bytes.
  std::int64_t max_joint_frames = 8'000'000;
  double body_margin_m = kBodyMargin_m;
  /// Where others want to work too: called by each of `threads` workers (0, 1, ...) before it makes a clip, to wait for its turn, and after
  /// that. Once any `begin` returns false, MakeVariants() stops. Worker 0 measures the set too.
  std::function<bool(int worker)> begin;
  std::function<void(int worker)> end;
  /// For a request with readings, see MakeSensorGuide(); they are made ready in worker 0's turn.
  SensorStepsSource sensor_steps = {};
};

/// Makes the variants of a request, those that can be met, ranks and measures them. The result does not depend on the number of threads.
///
/// Where none of the first 16 can be met, or these are so long that all would be too much by far, the rest is not tried.
/// @throws UnsatisfiableRequest of the first, when none can be met; VariantsTooLarge; VariantsCancelled; std::invalid_argument.
VariantSet MakeVariants(const MotionGraph& graph, const SynthesisRequest& request, const VariantOptions& options);

/// Measures clips as MakeVariants() does. `variants` as ranked; `asked` is told on.
VariantSummary SummariseVariants(const SynthesisRequest& request, int asked, const std::vector<ClipVariant>& variants, double body_margin_m,
                                 int threads);

}  // namespace morphograph
