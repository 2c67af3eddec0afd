#include "synthesis/motion_synthesizer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <vector>

#include "synthesis/control/steered_synthesis.h"
#include "synthesis/draw_index.h"
#include "synthesis/evaluation.h"
#include "synthesis/walk_clip.h"
#include "synthesis/walk_report.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {
namespace {

constexpr double kDefaultDuration_s = 5;

// Names of boundaries, or of styles, for people.
template <typename Values, typename NameOf>
std::string Listed(const Values& values, NameOf name_of) {
  std::string names;
  for (const auto& value : values) names += (names.empty() ? "" : ", ") + std::string(name_of(value));
  return names.empty() ? "none" : names;
}

bool Holds(const std::vector<WalkBoundary>& boundaries, WalkBoundary wanted) {
  return std::find(boundaries.begin(), boundaries.end(), wanted) != boundaries.end();
}

// The action asked for. @throws UnsatisfiableRequest where the graph has not learned it.
std::string ActionOf(const MotionGraph& graph, const SynthesisRequest& request) {
  const std::vector<std::string> actions = graph.action_names();
  if (!request.action) return actions.front();
  if (std::find(actions.begin(), actions.end(), *request.action) == actions.end()) {
    throw UnsatisfiableRequest("/action", "the model has no action '" + *request.action + "'; it has " +
                                              Listed(actions, [](const std::string& action) { return action; }));
  }
  return *request.action;
}

// Refuses a start or an end that the chosen style (any, where none was chosen) has not learned.
// @param styles  of the action asked for.
void CheckBoundaries(const std::vector<StyleBoundaries>& styles, const SynthesisRequest& request) {
  const auto check = [&](const char* pointer, const char* verb, WalkBoundary wanted, auto member) {
    if (wanted == WalkBoundary::kWalking) return;
    std::vector<std::string> able;
    const StyleBoundaries* chosen = styles.size() == 1 ? &styles[0] : nullptr;
    for (const StyleBoundaries& style : styles) {
      if (request.style == style.style) chosen = &style;
      if (Holds(style.*member, wanted)) able.push_back(style.style);
    }
    if (chosen ? Holds(chosen->*member, wanted) : !able.empty()) return;
    const std::string name(WalkBoundaryName(wanted));
    std::string detail = "no walk of " + (chosen && styles.size() > 1 ? "style '" + chosen->style + "'" : "this model") + " can " +
                         verb + " \"" + name + "\"";
    if (chosen) detail += "; it can " + std::string(verb) + ": " + Listed(chosen->*member, WalkBoundaryName);
    if (styles.size() > 1) detail += "; styles that can " + std::string(verb) + " \"" + name + "\": " +
                                     Listed(able, [](const std::string& style) { return style; });
    throw UnsatisfiableRequest(pointer, detail);
  };
  check("/start/from", "start from", request.start_from, &StyleBoundaries::starts);
  check("/end", "end in", request.end, &StyleBoundaries::ends);
}

int DrawStyle(const MotionGraph& graph, const SynthesisRequest& request, std::mt19937_64& rng) {
  const auto& styles = graph.styles();
  const std::string action = ActionOf(graph, request);
  const auto shows = [&](const GraphStyle& style) { return graph.action_of(style) == action; };
  const auto named = std::find_if(styles.begin(), styles.end(), [&](const GraphStyle& s) { return s.name == request.style && shows(s); });
  if (request.style && named == styles.end()) {
    throw UnsatisfiableRequest("/style", "the model has no style '" + *request.style + "'" +
                                             (graph.action_names().size() > 1 ? " of action '" + action + "'" : "") + "; it has " +
                                             Listed(graph.style_names(action), [](const std::string& style) { return style; }));
  }
  const bool walking = request.start_from == WalkBoundary::kWalking && request.end == WalkBoundary::kWalking;
  const std::vector<StyleBoundaries> boundaries = walking ? std::vector<StyleBoundaries>() : FindBoundaries(graph);
  if (!walking) {
    std::vector<StyleBoundaries> of_action;
    std::copy_if(boundaries.begin(), boundaries.end(), std::back_inserter(of_action),
                 [&](const StyleBoundaries& style) { return style.action == action; });
    CheckBoundaries(of_action, request);
  }
  if (request.style) return static_cast<int>(named - styles.begin());
  std::vector<double> weights(styles.size(), 0);
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MotionPrimitive& primitive = graph.primitive(p);
    if (IsSteady(primitive) && shows(styles[static_cast<size_t>(primitive.style_index)])) {
      weights[primitive.style_index] += primitive.initial_weight;
    }
  }
  for (size_t b = 0; b < boundaries.size(); ++b) {
    // Boundaries are in the order of the styles.
    if (!Holds(boundaries[b].starts, request.start_from) || !Holds(boundaries[b].ends, request.end)) weights[b] = 0;
  }
  const int drawn = DrawIndex(weights, rng);
  if (drawn < 0 && !walking) throw UnsatisfiableRequest("/end", "no style of this model can both start and end as asked");
  return std::max(0, drawn);
}

std::string Rounded(double value) { return std::to_string(std::lround(value)); }

}  // namespace

std::optional<std::pair<std::string, std::string>> SynthesisRequest::FirstProblem() const {
  using Problem = std::pair<std::string, std::string>;
  if (duration_s && steps) return Problem{"/steps", "give either a duration or a number of steps, not both"};
  if (duration_s && !(*duration_s > 0 && *duration_s <= kMaxDuration_s)) {
    return Problem{"/duration", "must be more than 0 and at most " + Rounded(kMaxDuration_s) + " seconds"};
  }
  if (steps && !(*steps >= 1 && *steps <= kMaxSteps)) {
    return Problem{"/steps", "must be from 1 to " + std::to_string(kMaxSteps)};
  }
  if (frame_rate_hz && !(*frame_rate_hz >= kMinFrameRate_hz && *frame_rate_hz <= kMaxFrameRate_hz)) {
    return Problem{"/output/frame_rate", "must be from " + Rounded(kMinFrameRate_hz) + " to " + Rounded(kMaxFrameRate_hz) +
                                             " frames a second"};
  }
  if (!start.position_m.allFinite() || start.position_m.cwiseAbs().maxCoeff() > kMaxStartDistance_m) {
    return Problem{"/start/position", "must be within " + Rounded(kMaxStartDistance_m) + " m of the origin"};
  }
  if (!std::isfinite(start.heading_rad)) return Problem{"/start/heading", "must be a number"};
  return control.FirstProblem();
}

SynthesisResult Synthesize(const MotionGraph& graph, const SynthesisRequest& request, const SynthesisVariant& variant) {
  if (const auto problem = request.FirstProblem()) {
    throw std::invalid_argument("SynthesisRequest: " + problem->first + " " + problem->second);
  }
  std::mt19937_64 rng(request.seed);
  const double rate_hz = request.frame_rate_hz.value_or(graph.frame_rate_hz());
  const int style = DrawStyle(graph, request, rng);
  if (!request.control.empty()) {
    SteeredWalk steered = SteerWalk(graph, request, style, rate_hz, rng);
    SynthesisResult result{std::move(steered.clip), {}};
    result.report = DescribeWalk(graph, steered.walk, result.clip, &steered.evaluation);
    result.report.seed = request.seed;
    result.report.constraints = std::move(steered.outcomes);
    return result;
  }
  const DrawnWalk walk = DrawWalk(graph,
                                  {.style = style,
                                   .from = request.start_from,
                                   .to = request.end,
                                   .steps = request.steps,
                                   .duration_s = request.duration_s.value_or(kDefaultDuration_s),
                                   .frame_rate_hz = rate_hz},
                                  rng);
  SynthesisResult result{MakeWalkClip(graph, walk.steps, walk.frames, rate_hz, request.start, variant), {}};
  result.report = DescribeWalk(graph, walk, result.clip);
  result.report.seed = request.seed;
  return result;
}

}  // namespace morphograph
