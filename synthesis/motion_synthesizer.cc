#include "synthesis/motion_synthesizer.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "synthesis/control/sensor_guide.h"
#include "synthesis/control/steered_synthesis.h"
#include "synthesis/draw_index.h"
#include "synthesis/evaluation.h"
#include "synthesis/walk_clip.h"
#include "synthesis/walk_report.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {
namespace {

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

// The entry of another action among the styles of the graph; -1 where it has none of that name.
int StyleOfAction(const MotionGraph& graph, int style, const std::string& action) {
  const auto& styles = graph.styles();
  for (size_t s = 0; s < styles.size(); ++s) {
    if (styles[s].name == styles[static_cast<size_t>(style)].name && graph.action_of(styles[s]) == action) return static_cast<int>(s);
  }
  return -1;
}

bool CanChange(const MotionGraph& graph, int from_style, int to_style) {
  return std::any_of(graph.changes().begin(), graph.changes().end(), [&](const ActionChange& change) {
    return graph.primitive(change.from).style_index == from_style && graph.primitive(change.to).style_index == to_style;
  });
}

// The changes asked for, for a walk that begins in a style; as many as it can make.
std::vector<StyleChange> ChangesOf(const MotionGraph& graph, int style, const std::vector<ActionFrom>& asked) {
  std::vector<StyleChange> changes;
  for (const ActionFrom& next : asked) {
    const int to = StyleOfAction(graph, style, next.action);
    if (to < 0 || !CanChange(graph, style, to)) break;
    changes.push_back({next.at_s, to});
    style = to;
  }
  return changes;
}

// Refuses changes of action that the chosen style (any, where none was chosen) cannot make.
// @param styles  of the first action. @return which of them can.
std::vector<bool> CheckChanges(const MotionGraph& graph, const std::vector<int>& styles, const SynthesisRequest& request) {
  const std::vector<std::string> actions = graph.action_names();
  for (size_t i = 0; i < request.changes.size(); ++i) {
    if (std::find(actions.begin(), actions.end(), request.changes[i].action) != actions.end()) continue;
    throw UnsatisfiableRequest("/actions/" + std::to_string(i + 1) + "/action",
                               "the model has no action '" + request.changes[i].action + "'; it has " +
                                   Listed(actions, [](const std::string& action) { return action; }));
  }
  std::vector<bool> can(graph.styles().size(), false);
  std::vector<std::string> able;
  std::optional<size_t> stopped;  // how many changes the best of the styles asked for can make
  for (const int style : styles) {
    const std::string& name = graph.styles()[static_cast<size_t>(style)].name;
    const size_t count = ChangesOf(graph, style, request.changes).size();
    can[static_cast<size_t>(style)] = count == request.changes.size();
    if (can[static_cast<size_t>(style)]) able.push_back(name);
    if (!request.style || request.style == name) stopped = std::max(stopped.value_or(0), count);
  }
  if (stopped && *stopped < request.changes.size()) {
    const std::string before = *stopped == 0 ? ActionOf(graph, request) : request.changes[*stopped - 1].action;
    throw UnsatisfiableRequest("/actions/" + std::to_string(*stopped + 1) + "/action",
                               (request.style ? "style '" + *request.style + "'" : "no style of the model") +
                                   (request.style ? " cannot" : " can") + " change from '" + before + "' to '" +
                                   request.changes[*stopped].action + "': its recordings hold no steps of both that are near enough; " +
                                   "styles that can change as asked: " + Listed(able, [](const std::string& name) { return name; }));
  }
  return can;
}

// Refuses a start or an end that the chosen style (any, where none was chosen) has not learned.
// @param styles  of the action asked for.
// @param last  of the action that the clip ends in.
void CheckBoundaries(const std::vector<StyleBoundaries>& first, const std::vector<StyleBoundaries>& last, const SynthesisRequest& request) {
  const auto check = [&](const std::vector<StyleBoundaries>& styles, const char* pointer, const char* verb, WalkBoundary wanted, auto member) {
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
  check(first, "/start/from", "start from", request.start_from, &StyleBoundaries::starts);
  check(last, "/end", "end in", request.end, &StyleBoundaries::ends);
}

// The entry of the style that a clip ends in.
int LastStyle(const MotionGraph& graph, int style, const SynthesisRequest& request) {
  const std::vector<StyleChange> changes = ChangesOf(graph, style, request.changes);
  return changes.empty() ? style : changes.back().style;
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
  std::vector<int> able;  // styles of that action, then those of them that can change as asked
  for (size_t s = 0; s < styles.size(); ++s) {
    if (shows(styles[s])) able.push_back(static_cast<int>(s));
  }
  if (!request.changes.empty()) {
    const std::vector<bool> can = CheckChanges(graph, able, request);
    std::erase_if(able, [&](int style) { return !can[static_cast<size_t>(style)]; });
  }
  const bool walking = request.start_from == WalkBoundary::kWalking && request.end == WalkBoundary::kWalking;
  const std::vector<StyleBoundaries> boundaries = walking ? std::vector<StyleBoundaries>() : FindBoundaries(graph);
  if (!walking) {
    std::vector<StyleBoundaries> first, last;  // boundaries are in the order of the styles
    for (const int style : able) {
      first.push_back(boundaries[static_cast<size_t>(style)]);
      last.push_back(boundaries[static_cast<size_t>(LastStyle(graph, style, request))]);
    }
    CheckBoundaries(first, last, request);
  }
  if (request.style) return static_cast<int>(named - styles.begin());
  std::vector<double> weights(styles.size(), 0);
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MotionPrimitive& primitive = graph.primitive(p);
    if (IsSteady(primitive) && std::find(able.begin(), able.end(), primitive.style_index) != able.end()) {
      weights[primitive.style_index] += primitive.initial_weight;
    }
  }
  for (size_t b = 0; b < boundaries.size(); ++b) {
    const size_t last = static_cast<size_t>(LastStyle(graph, static_cast<int>(b), request));
    if (!Holds(boundaries[b].starts, request.start_from) || !Holds(boundaries[last].ends, request.end)) weights[b] = 0;
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
  double before_s = 0;
  for (size_t i = 0; i < changes.size(); ++i) {
    if (changes[i].at_s > before_s && changes[i].at_s < duration_s.value_or(kDefaultDuration_s)) {
      before_s = changes[i].at_s;
      continue;
    }
    return Problem{"/actions/" + std::to_string(i) + "/until", "must be after the one before it, and before the clip's end"};
  }
  if (!changes.empty() && steps) return Problem{"/steps", "a clip that changes its action has a duration, not a number of steps"};
  if (!changes.empty() && !control.empty()) {
    return Problem{"/actions", "a clip that changes its action cannot be told where to go or what to do on its way"};
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
  if (request.control.sensors && !request.control.sensors->guide) {
    SynthesisRequest prepared = request;
    PrepareSensors(graph, &prepared);
    return Synthesize(graph, prepared, variant);
  }
  int style = DrawStyle(graph, request, rng);
  // Readings know more of the style than a draw does.
  if (request.control.sensors && !request.style && !request.control.sensors->guide->walk.steps.empty()) style = request.control.sensors->guide->walk.style;
  if (!request.control.empty()) {
    SteeredWalk steered = SteerWalk(graph, request, style, rate_hz, rng);
    SynthesisResult result{std::move(steered.clip), {}};
    result.report = DescribeWalk(graph, steered.walk, result.clip, &steered.evaluation);
    result.report.seed = request.seed;
    result.report.constraints = std::move(steered.outcomes);
    if (request.control.sensors) result.report.sensors = request.control.sensors->guide;
    return result;
  }
  const DrawnWalk walk = DrawWalk(graph,
                                  {.style = style,
                                   .from = request.start_from,
                                   .to = request.end,
                                   .steps = request.steps,
                                   .duration_s = request.duration_s.value_or(kDefaultDuration_s),
                                   .frame_rate_hz = rate_hz,
                                   .changes = ChangesOf(graph, style, request.changes)},
                                  rng);
  SynthesisResult result{MakeWalkClip(graph, walk.steps, walk.frames, rate_hz, request.start, variant), {}};
  result.report = DescribeWalk(graph, walk, result.clip);
  result.report.seed = request.seed;
  return result;
}

}  // namespace morphograph
