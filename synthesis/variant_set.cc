#include "synthesis/variant_set.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <tuple>

#include "datasets/parallel_for.h"
#include "synthesis/control/floor_path.h"
#include "synthesis/control/sensor_guide.h"
#include "synthesis/joint_spread.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

constexpr int kTrial = 16;
constexpr int kClipPhases = 20;
constexpr int kStepPhases = 10;
constexpr std::size_t kMostSteps = 200;

// What became of one seed.
struct Attempt {
  std::optional<ClipVariant> made;
  std::optional<UnsatisfiableRequest> unmet;
};

MeasuredRange RangeOf(const std::vector<double>& values) {
  MeasuredRange range{values.front(), 0, values.front()};
  for (const double value : values) {
    range.min = std::min(range.min, value);
    range.max = std::max(range.max, value);
    range.mean += value / static_cast<double>(values.size());
  }
  return range;
}

// A caller's leave to work, for a while.
class Turn {
 public:
  Turn(const VariantOptions& options, int worker) : options_(options), worker_(worker) {
    if (options.begin && !options.begin(worker)) throw VariantsCancelled();
  }
  ~Turn() {
    if (options_.end) options_.end(worker_);
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  const VariantOptions& options_;
  const int worker_;
};

// When the root is within a tolerance of a place for good; the clip's end where it never is.
double ArrivalTime_s(const ClipVariant& variant, const Eigen::Vector2d& place_m, double tolerance_m) {
  const auto& path_m = variant.report.path_m;
  std::size_t frame = path_m.size();
  while (frame > 0 && (path_m[frame - 1] - place_m).norm() <= tolerance_m) --frame;
  return std::min(static_cast<double>(frame) / variant.clip.frame_rate_hz(), variant.clip.duration_s());
}

// Of steps of one primitive, evenly picked.
double StepSpread_m(const std::vector<ClipVariant>& variants, int threads) {
  struct Stretch {
    const ClipVariant* variant;
    const StepReport* step;
  };
  std::map<std::string, std::vector<Stretch>> by_primitive;
  for (const ClipVariant& variant : variants) {
    for (const StepReport& step : variant.report.steps) {
      // The first and the last step hold the margins of the walk, or are cut.
      const bool is_inner = &step != &variant.report.steps.front() && &step != &variant.report.steps.back();
      if (is_inner && step.to > step.from) by_primitive[step.primitive].push_back({&variant, &step});
    }
  }
  double sum = 0, pairs = 0;
  for (const auto& [primitive, all] : by_primitive) {
    const std::size_t count = std::min(all.size(), kMostSteps);
    std::vector<JointSamples> samples(count);
    ParallelFor(threads, static_cast<int>(count), [&](int i) {
      const auto& [variant, step] = all[static_cast<std::size_t>(i) * all.size() / count];
      samples[static_cast<std::size_t>(i)] = SampleJoints(variant->clip, step->from, step->to, kStepPhases, SampleFrame::kBody);
    });
    const double weight = static_cast<double>(count) * static_cast<double>(count - 1) / 2;
    sum += weight * MeanPairwiseJointDistance(samples);
    pairs += weight;
  }
  return pairs > 0 ? sum / pairs : 0;
}

}  // namespace

VariantSummary SummariseVariants(const SynthesisRequest& request, int asked, const std::vector<ClipVariant>& variants, double body_margin_m,
                                 int threads) {
  VariantSummary summary;
  summary.asked = asked;
  summary.made = static_cast<int>(variants.size());
  if (variants.empty()) return summary;

  std::vector<double> durations_s, arrivals_s;
  for (const ClipVariant& variant : variants) durations_s.push_back(variant.clip.duration_s());
  summary.duration_s = RangeOf(durations_s);
  const auto& [path, goal] = std::tie(request.control.path, request.control.goal);
  if (path || goal) {
    for (const ClipVariant& variant : variants) {
      arrivals_s.push_back(goal ? ArrivalTime_s(variant, goal->position_m, goal->tolerance_m)
                                : ArrivalTime_s(variant, path->points_m.back(), path->tolerance_m));
    }
    summary.arrival_s = RangeOf(arrivals_s);
  }

  struct Measured {
    JointSamples samples;
    FloorCells cells;
    double deviation_sum_m = 0, deviation_max_m = 0;
  };
  std::vector<Measured> measured(variants.size());
  const std::optional<FloorPath> line = path ? std::optional<FloorPath>(std::in_place, path->points_m, path->smooth) : std::nullopt;
  ParallelFor(threads, static_cast<int>(variants.size()), [&](int i) {
    const ClipVariant& variant = variants[static_cast<std::size_t>(i)];
    Measured& result = measured[static_cast<std::size_t>(i)];
    result.samples = SampleJoints(variant.clip, 0, variant.clip.frame_count() - 1, kClipPhases, SampleFrame::kWorld);
    result.cells = CellsBelow(variant.clip);
    for (const Eigen::Vector2d& root_m : variant.report.path_m) {
      if (!line) break;
      const double distance_m = line->NearestTo(root_m).distance_m;
      result.deviation_sum_m += distance_m;
      result.deviation_max_m = std::max(result.deviation_max_m, distance_m);
    }
  });
  std::vector<JointSamples> samples;
  std::vector<FloorCells> cells;
  double deviation_sum_m = 0, deviation_max_m = 0, frames = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    samples.push_back(std::move(measured[i].samples));
    cells.push_back(std::move(measured[i].cells));
    deviation_sum_m += measured[i].deviation_sum_m;
    deviation_max_m = std::max(deviation_max_m, measured[i].deviation_max_m);
    frames += static_cast<double>(variants[i].report.path_m.size());
  }
  if (line && frames > 0) {
    summary.path_deviation_mean_m = deviation_sum_m / frames;
    summary.path_deviation_max_m = deviation_max_m;
  }
  summary.clip_spread_m = MeanPairwiseJointDistance(samples);
  summary.step_spread_m = StepSpread_m(variants, threads);
  summary.swept_area = OutlineOf(cells, body_margin_m);
  return summary;
}

VariantSet MakeVariants(const MotionGraph& graph, const SynthesisRequest& asked, const VariantOptions& options) {
  SynthesisRequest request = asked;
  if (options.count < 1) throw std::invalid_argument("MakeVariants: count must be at least 1");
  if (request.control.sensors) {
    const Turn turn(options, 0);
    PrepareSensors(graph, &request, options.sensor_steps);
  }
  std::vector<Attempt> attempts(static_cast<std::size_t>(options.count));
  std::atomic<std::int64_t> joint_frames = 0;
  const auto attempt = [&](int worker, int index) {
    const Turn turn(options, worker);
    SynthesisRequest variant = request;
    variant.seed = request.seed + static_cast<std::uint64_t>(index);
    Attempt& result = attempts[static_cast<std::size_t>(index)];
    try {
      SynthesisResult made = Synthesize(graph, variant);
      joint_frames += std::int64_t{made.clip.joint_count()} * made.clip.frame_count();
      if (joint_frames > options.max_joint_frames) {
        throw VariantsTooLarge("all variants together may have " + std::to_string(options.max_joint_frames / made.clip.joint_count()) +
                               " frames");
      }
      const double steps = std::max<double>(1, static_cast<double>(made.report.steps.size()));
      const double per_step = made.report.quality.log_likelihood.value_or(0) / steps;
      result.made.emplace(ClipVariant{index, std::move(made.clip), std::move(made.report), per_step});
    } catch (const UnsatisfiableRequest& unmet) {
      result.unmet = unmet;
    }
  };
  // Indices [from, to), by all threads; each takes the next one that is left.
  const auto make = [&](int from, int to) {
    std::atomic<int> next = from;
    ParallelFor(options.threads, std::clamp(options.threads, 1, std::max(1, to - from)), [&](int worker) {
      try {
        for (int i = next++; i < to; i = next++) attempt(worker, i);
      } catch (...) {
        next = to;
        throw;
      }
    });
  };
  const int trial = std::min(options.count, kTrial);
  make(0, trial);
  const bool any = std::any_of(attempts.begin(), attempts.begin() + trial, [](const Attempt& a) { return a.made.has_value(); });
  if (!any) throw UnsatisfiableRequest(*attempts.front().unmet);
  // Told early where it is plain; near the limit it is found out on the way.
  const double foreseen = static_cast<double>(joint_frames) * options.count / trial;
  if (foreseen > 1.25 * static_cast<double>(options.max_joint_frames)) {
    throw VariantsTooLarge("about " + std::to_string(static_cast<int>(options.count * static_cast<double>(options.max_joint_frames) / foreseen)) +
                           " clips of this length can be made at a time");
  }
  make(trial, options.count);

  VariantSet set;
  for (Attempt& attempted : attempts) {
    if (attempted.made) set.variants.push_back(std::move(*attempted.made));
  }
  std::stable_sort(set.variants.begin(), set.variants.end(),
                   [](const ClipVariant& a, const ClipVariant& b) { return a.log_likelihood_per_step > b.log_likelihood_per_step; });
  const Turn turn(options, 0);
  set.summary = SummariseVariants(request, options.count, set.variants, options.body_margin_m, options.begin ? 1 : options.threads);
  return set;
}

}  // namespace morphograph
