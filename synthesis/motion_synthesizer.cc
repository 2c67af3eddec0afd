#include "synthesis/motion_synthesizer.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "synthesis/evaluation.h"
#include "synthesis/foot_lock.h"
#include "synthesis/graph_walk.h"
#include "synthesis/step_joiner.h"
#include "synthesis/step_track.h"

namespace morphograph {
namespace {

constexpr double kDefaultDuration_s = 5;
constexpr double kLongest_s = 600;
constexpr int kMostSteps = 1000;
constexpr double kHighestFrameRate_hz = 240;
// Steps drawn and thrown away before the clip begins, so that its first step is as much a product of the transitions as any other.
constexpr int kBurnInSteps = 3;

bool IsWalking(KeyframeLabel label) { return label == KeyframeLabel::kLeftStance || label == KeyframeLabel::kRightStance; }

bool IsSteady(const MotionPrimitive& primitive) { return IsWalking(primitive.start) && IsWalking(primitive.end); }

int DrawStyle(const MotionGraph& graph, const SynthesisRequest& request, std::mt19937_64& rng) {
  const auto& styles = graph.styles();
  if (request.style) {
    for (size_t s = 0; s < styles.size(); ++s) {
      if (styles[s].name == *request.style) return static_cast<int>(s);
    }
    std::string known;
    for (const std::string& name : graph.style_names()) known += (known.empty() ? "" : ", ") + name;
    throw UnsatisfiableRequest("/style", "the model has no style '" + *request.style + "'; it has " +
                                             (known.empty() ? "none" : known));
  }
  std::vector<double> weights(styles.size(), 0);
  for (int p = 0; p < graph.primitive_count(); ++p) {
    weights[graph.primitive(p).style_index] += graph.primitive(p).initial_weight;
  }
  return std::max(0, DrawIndex(weights, rng));
}

// An edge that keeps walking, by probability; -1 where the walk has to end.
int DrawWalkingEdge(const MotionGraph& graph, int primitive, std::mt19937_64& rng) {
  const std::vector<int>& edges = graph.out_edges(primitive);
  std::vector<double> weights;
  for (const int edge : edges) {
    const int target = graph.edge_to(edge);
    const bool goes_on = IsSteady(graph.primitive(target)) && !graph.is_dead_end(target);
    weights.push_back(goes_on ? graph.transition(edge).probability : 0);
  }
  const int drawn = DrawIndex(weights, rng);
  return drawn < 0 ? -1 : edges[drawn];
}

WalkStep DrawSteadyStep(const MotionGraph& graph, int style, std::mt19937_64& rng) {
  std::vector<double> weights;
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MotionPrimitive& primitive = graph.primitive(p);
    const bool fits = primitive.style_index == style && IsSteady(primitive) && !graph.is_dead_end(p);
    weights.push_back(fits ? primitive.initial_weight : 0);
  }
  const int drawn = DrawIndex(weights, rng);
  if (drawn < 0) {
    throw UnsatisfiableRequest("/style", "the model has no steady steps of style '" + graph.styles()[style].name + "'");
  }
  WalkStep step = DrawFirstStep(graph, drawn, rng);
  for (int i = 0; i < kBurnInSteps; ++i) {
    const int edge = DrawWalkingEdge(graph, step.primitive, rng);
    if (edge < 0) break;
    step = DrawNextStep(graph, step, edge, rng);
  }
  return step;
}

struct DrawnStep {
  WalkStep step;
  StepShape shape;
  double start = 0;  // frames
  double end = 0;
};

// Draws steps until `steps` of them are there, or `frames` are filled with a cross-fade to spare.
std::vector<DrawnStep> DrawWalk(const MotionGraph& graph, int style, std::optional<int> steps, double frames, double rate_hz,
                                std::mt19937_64& rng) {
  std::vector<DrawnStep> walk;
  WalkStep step = DrawSteadyStep(graph, style, rng);
  double time = 0;
  while (true) {
    StepShape shape = graph.primitive(step.primitive).Shape(step.latent);
    const double length = shape.duration_s * rate_hz;
    walk.push_back({step, std::move(shape), time, time + length});
    time += length;
    const bool enough = steps ? static_cast<int>(walk.size()) >= *steps : time > frames + CrossFadeHalfWidth(1e9, 1e9, rate_hz);
    if (enough) return walk;
    const int edge = DrawWalkingEdge(graph, step.primitive, rng);
    if (edge < 0) {
      throw UnsatisfiableRequest(steps ? "/steps" : "/duration", "the model cannot walk on after '" +
                                                                     graph.primitive(step.primitive).name + "'");
    }
    step = DrawNextStep(graph, step, edge, rng);
  }
}

std::vector<StepTrack> LayOut(const MotionGraph& graph, const std::vector<DrawnStep>& walk, int frames, double rate_hz) {
  std::vector<StepTrack> tracks;
  for (size_t k = 0; k < walk.size(); ++k) {
    if (walk[k].start > frames) break;
    const auto fade = [&](size_t a, size_t b) {
      return CrossFadeHalfWidth(walk[a].end - walk[a].start, walk[b].end - walk[b].start, rate_hz);
    };
    // One frame more than the cross-fade: increments look to the next frame.
    const double before = k > 0 ? fade(k - 1, k) + 1 : 0;
    const double after = k + 1 < walk.size() ? fade(k, k + 1) + 2 : 1;
    const int first = std::max(0, static_cast<int>(std::floor(walk[k].start - before)));
    const int last = std::min(frames, static_cast<int>(std::ceil(walk[k].end + after)));
    tracks.push_back(LayOutStep(graph.primitive(walk[k].step.primitive), walk[k].shape, walk[k].start, rate_hz, first,
                                std::max(first, last)));
  }
  return tracks;
}

std::vector<StepReport> ReportSteps(const MotionGraph& graph, const std::vector<DrawnStep>& walk, int frames) {
  std::vector<StepReport> steps;
  for (const DrawnStep& drawn : walk) {
    const int from = static_cast<int>(std::ceil(drawn.start));
    if (from >= frames) break;
    const int to = std::min(frames - 1, static_cast<int>(std::ceil(drawn.end)) - 1);
    steps.push_back({graph.primitive(drawn.step.primitive).name, from, std::max(from, to), drawn.step.log_likelihood});
  }
  return steps;
}

}  // namespace

std::optional<std::pair<std::string, std::string>> SynthesisRequest::FirstProblem() const {
  using Problem = std::pair<std::string, std::string>;
  if (duration_s && steps) return Problem{"/steps", "give either a duration or a number of steps, not both"};
  if (duration_s && !(*duration_s > 0 && *duration_s <= kLongest_s)) {
    return Problem{"/duration", "must be more than 0 and at most 600 seconds"};
  }
  if (steps && !(*steps >= 1 && *steps <= kMostSteps)) return Problem{"/steps", "must be from 1 to 1000"};
  if (frame_rate_hz && !(*frame_rate_hz >= 1 && *frame_rate_hz <= kHighestFrameRate_hz)) {
    return Problem{"/output/frame_rate", "must be from 1 to 240 frames a second"};
  }
  if (!start.position_m.allFinite() || start.position_m.cwiseAbs().maxCoeff() > 1e6) {
    return Problem{"/start/position", "must be within 1,000 km of the origin"};
  }
  if (!std::isfinite(start.heading_rad)) return Problem{"/start/heading", "must be a number"};
  return std::nullopt;
}

SynthesisResult Synthesize(const MotionGraph& graph, const SynthesisRequest& request) {
  if (const auto problem = request.FirstProblem()) {
    throw std::invalid_argument("SynthesisRequest: " + problem->first + " " + problem->second);
  }
  std::mt19937_64 rng(request.seed);
  const double rate_hz = request.frame_rate_hz.value_or(graph.frame_rate_hz());
  const int style = DrawStyle(graph, request, rng);
  const double duration_s = request.duration_s.value_or(kDefaultDuration_s);
  int frames = static_cast<int>(std::floor(duration_s * rate_hz + 1e-9)) + 1;
  const std::vector<DrawnStep> walk = DrawWalk(graph, style, request.steps, frames, rate_hz, rng);
  if (request.steps) frames = static_cast<int>(std::floor(walk.back().end)) + 1;

  JoinedSteps joined = JoinSteps(graph, LayOut(graph, walk, frames, rate_hz), frames, rate_hz, request.start);
  LockFeet(graph.styles()[style].feet, joined.contacts, {}, &joined.clip);

  SynthesisResult result{std::move(joined.clip), {}};
  result.clip.style = graph.styles()[style].name;
  SynthesisReport& report = result.report;
  report.seed = request.seed;
  report.model_name = graph.name();
  report.model_hash = graph.hash();
  report.style = result.clip.style;
  report.frames = frames;
  report.duration_s = result.clip.duration_s();
  report.steps = ReportSteps(graph, walk, frames);
  for (int f = 0; f < frames; ++f) {
    const Eigen::Vector3d root = result.clip.root_positions().col(f);
    report.path_m.emplace_back(root.x(), root.z());
  }
  if (frames >= 2) {
    ClipEvaluation evaluation = EvaluateClip(result.clip);
    report.contacts = std::move(evaluation.contacts);
    report.quality = evaluation.quality;
  }
  double log_likelihood = 0;
  for (const StepReport& step : report.steps) log_likelihood += step.log_likelihood;
  report.quality.log_likelihood = log_likelihood;
  return result;
}

}  // namespace morphograph
