#include "graph/graph_builder.h"

#include <algorithm>

#include "datasets/parallel_for.h"
#include "graph/action_change_fit.h"
#include "graph/component_balance.h"
#include "graph/internal/training_progress.h"
#include "graph/manner_fit.h"
#include "graph/model_io.h"
#include "graph/primitive_fit.h"
#include "graph/recorded_motion.h"
#include "graph/step_pairs.h"
#include "graph/training_set.h"
#include "graph/transition_fit.h"

namespace morphograph {
namespace {

// Frame rate at which clips come out unless asked otherwise: what 25 samples over a step and its margins can carry.
constexpr double kModelRate_hz = 30;
constexpr int kFewestPairs = 2;

std::string Named(const StepClass& members) { return NameInNotes(members.primitive, members.style, members.other_action); }

void NoteMissingPrimitives(const GraphContents& contents, std::vector<std::string>* notes) {
  for (size_t s = 0; s < contents.styles.size(); ++s) {
    const GraphStyle& style = contents.styles[s];
    const std::string& action = style.other_action.empty() ? contents.action : style.other_action;
    const std::vector<std::string> wanted = {"left_" + action,    "right_" + action, "left_first_start",
                                             "right_first_start", "left_end",        "right_end"};
    for (const std::string& name : wanted) {
      const bool there = std::any_of(contents.primitives.begin(), contents.primitives.end(), [&](const MotionPrimitive& p) {
        return p.style_index == static_cast<int>(s) && p.name == name;
      });
      const std::string label = NameInNotes(name, style.name, style.other_action);
      const bool noted = std::any_of(notes->begin(), notes->end(),
                                     [&](const std::string& note) { return note.starts_with(label + ": only"); });
      if (!there && !noted) {
        notes->push_back(label + ": the data hold no such steps");
      }
    }
  }
}

PairManner MannerOf(const FittedPrimitive& fitted, const std::vector<int>& places) {
  if (fitted.primitive.manner.empty()) return {};
  return {fitted.primitive.manner.WithinScale(fitted.latents.rows()), fitted.manners(Eigen::all, places)};
}

std::vector<GraphEdge> FitEdges(const TrainingSet& set, const std::vector<FittedPrimitive>& fitted, const TrainingOptions& options,
                                TrainingProgress* progress, std::vector<std::string>* notes) {
  std::vector<StepPairs> pairs = FindStepPairs(set);
  std::erase_if(pairs, [&](const StepPairs& list) {
    if (list.size() >= kFewestPairs) return false;
    const StepClass &from = set.classes[list.from], &to = set.classes[list.to];
    notes->push_back(Named(from) + " to " + Named(to) + ": seen " + std::to_string(list.size()) +
                     " time, at least " + std::to_string(kFewestPairs) + " are needed for a transition; left out");
    return true;
  });
  std::vector<GraphEdge> edges;
  std::vector<double> leaving(set.classes.size(), 0);
  for (const StepPairs& list : pairs) {
    edges.push_back({list.from, list.to, {}});
    leaving[list.from] += list.size();
  }
  progress->Begin("transitions", 0.6, 0.95, static_cast<int>(edges.size()));
  ParallelFor(options.jobs, static_cast<int>(edges.size()), [&](int e) {
    const FittedPrimitive& from = fitted[edges[e].from];
    const FittedPrimitive& to = fitted[edges[e].to];
    TransitionFitOptions fit;
    fit.form = options.variant.transition;
    // Steps after a start still gather speed: they are not the steady ones that their primitive was learned from.
    fit.keep_marginal = IsWalking(from.primitive.start) || !IsWalking(to.primitive.end);
    TransitionPairs latents = LatentsOf(pairs[e], from.latents, to.latents);
    latents.previous_manner = MannerOf(from, pairs[e].previous);
    latents.next_manner = MannerOf(to, pairs[e].next);
    fit.margin = FindSharedMargin(from.primitive, to.primitive, set.layout, StyleOf(set, set.classes[edges[e].to]).mean_rotations, set.channel_weights);
    edges[e].model = FitTransition(latents, from.primitive.mixture, to.primitive.mixture, fit);
    edges[e].model.probability = pairs[e].size() / leaving[edges[e].from];
    progress->Step();
  });
  return edges;
}

}  // namespace

std::shared_ptr<const MotionGraph> BuildGraph(const std::vector<TrainingClip>& clips, const TrainingOptions& options) {
  TrainingProgress progress(options);
  GraphContents contents;
  contents.name = options.name;
  contents.action = options.action;
  contents.provenance.source = options.source;
  contents.provenance.licence = options.licence;
  contents.provenance.attribution = options.attribution;
  contents.provenance.command = options.command;
  contents.provenance.clips = static_cast<int>(clips.size());
  for (const TrainingClip& clip : clips) contents.provenance.frames += clip.clip.frame_count();
  std::vector<std::string>& notes = contents.provenance.notes;

  const TrainingSet set = PrepareTrainingSet(clips, options, &progress);
  const std::vector<PreparedClip>& prepared = set.clips;
  const std::vector<StepClass>& classes = set.classes;
  notes = set.notes;
  double highest_hz = 0;  // whatever the order of the clips
  for (const PreparedClip& clip : prepared) highest_hz = std::max(highest_hz, clip.clip.frame_rate_hz());
  contents.frame_rate_hz = std::min(highest_hz, kModelRate_hz);
  contents.layout = set.layout;
  contents.styles = set.styles;
  if (options.keep_recordings) contents.recordings = std::make_shared<const RecordedMotion>(RecordMotion(set));

  progress.Begin("primitives", 0.25, 0.6, static_cast<int>(classes.size()));
  std::vector<FittedPrimitive> fitted(classes.size());
  ParallelFor(options.jobs, static_cast<int>(classes.size()), [&](int c) {
    const GraphStyle& style = StyleOf(set, classes[c]);
    fitted[c] = FitPrimitive(prepared, set.steps, classes[c], set.layout, style.mean_rotations, set.channel_weights,
                             {.variance_kept = options.variance_kept, .seed = options.seed, .variant = options.variant});
    fitted[c].primitive.style_index = static_cast<int>(&style - set.styles.data());
    progress.Step();
  });
  if (options.variant.manner) FitManners(set, &fitted);
  contents.edges = FitEdges(set, fitted, options, &progress, &notes);
  if (options.variant.transition == TrainingVariant::Transition::kStationary) BalanceComponents(&fitted, &contents.edges);
  contents.changes = FindActionChanges(set, fitted, contents.action, &notes);
  for (FittedPrimitive& f : fitted) contents.primitives.push_back(std::move(f.primitive));

  NoteMissingPrimitives(contents, &notes);
  for (size_t p = 0; p < contents.primitives.size(); ++p) {
    const bool leaves = std::any_of(contents.edges.begin(), contents.edges.end(),
                                    [&](const GraphEdge& edge) { return edge.from == static_cast<int>(p); });
    if (!leaves) notes.push_back(Named(classes[p]) + ": dead end, no transition leaves it");
  }
  progress.Begin("model", 0.95, 1.0, 1);
  // What is returned is what a reader of the file gets, to the last bit.
  std::shared_ptr<const MotionGraph> graph = ParseModel(SerialiseModel(MotionGraph(std::move(contents), "")), options.name);
  progress.Step();
  return graph;
}

}  // namespace morphograph
