#include "graph/graph_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "graph/model_io.h"
#include "graph/primitive_fit.h"
#include "graph/training_steps.h"
#include "graph/transition_fit.h"
#include "primitives/keyframe_detector.h"

namespace morphograph {
namespace {

// Steps are sampled at some 30 Hz; more than this only costs time.
constexpr double kWorkRate_hz = 60;
// Frame rate at which clips come out unless asked otherwise: what 25 samples over a step and its margins can carry.
constexpr double kModelRate_hz = 30;
constexpr double kSlowestRate_hz = 10;  // below, a step has fewer than five frames
constexpr int kFewestSteps = 4;   // of a steady kind, to be worth a primitive
constexpr int kFewestStarts = 2;  // of a start or an end, of which captures hold few
constexpr int kFewestPairs = 2;
// Contact labels say where a foot may be held, so they are stricter than what counts as a contact elsewhere: a foot that rolls
// off at half a metre a second must not be held.
constexpr double kPlantedHeight_m = 0.04;
constexpr double kPlantedSpeed_m_s = 0.35;

class Progress {
 public:
  explicit Progress(const TrainingOptions& options) : options_(options) {}
  void Begin(const std::string& stage, double from, double to, int work) {
    const std::lock_guard lock(mutex_);
    stage_ = stage, from_ = from, to_ = to, work_ = std::max(1, work), done_ = 0;
    Tell();
  }
  void Step() {
    if (options_.cancelled && options_.cancelled->load()) throw TrainingCancelled();
    const std::lock_guard lock(mutex_);
    ++done_;
    Tell();
  }

 private:
  void Tell() const {
    if (options_.progress) options_.progress(stage_, from_ + (to_ - from_) * done_ / work_);
  }
  const TrainingOptions& options_;
  std::mutex mutex_;
  std::string stage_;
  double from_ = 0, to_ = 0;
  int work_ = 1, done_ = 0;
};

bool IsWalking(KeyframeLabel label) {
  return label == KeyframeLabel::kLeftStance || label == KeyframeLabel::kRightStance;
}

bool IsWalkStep(const TrainingStep& step) { return IsWalking(step.start) && IsWalking(step.end); }

// Every clip on the skeleton of the first one, at a rate that is worth its work.
std::vector<PreparedClip> PrepareClips(const std::vector<TrainingClip>& clips, const TrainingOptions& options, Progress* progress,
                                       std::vector<std::string>* notes) {
  const std::shared_ptr<const Skeleton> skeleton = clips.front().clip.shared_skeleton();
  const std::vector<std::string> missing = skeleton->roles().Missing(LocomotionRoles());
  if (!missing.empty()) {
    std::string names;
    for (const std::string& name : missing) names += (names.empty() ? "" : ", ") + name;
    throw DatasetError(clips.front().clip.name, "the skeleton has no joint for " + names + "; name them in a manifest's \"roles\"");
  }
  std::vector<PreparedClip> prepared(clips.size());
  std::vector<std::string> problems(clips.size());
  ParallelFor(options.jobs, static_cast<int>(clips.size()), [&](int i) {
    MotionClip clip = clips[i].clip;
    if (clip.frame_count() < 2) {
      problems[i] = clip.name + ": fewer than 2 frames; left out";
    } else if (clip.frame_rate_hz() < kSlowestRate_hz) {
      problems[i] = clip.name + ": recorded at " + std::to_string(std::lround(clip.frame_rate_hz())) +
                    " frames a second, at least " + std::to_string(std::lround(kSlowestRate_hz)) + " are needed; left out";
    } else {
      try {
        if (clip.shared_skeleton() != skeleton) clip = Retarget(clip, skeleton);
      } catch (const std::invalid_argument& unfit) {
        throw DatasetError(clip.name, "cannot be put on the skeleton of " + clips.front().clip.name + ": " + ReasonOf(unfit));
      }
      if (clip.frame_rate_hz() > kWorkRate_hz * 1.01) clip = Resample(clip, kWorkRate_hz);
      prepared[i].contacts = DetectContacts(clip, {.height_m = kPlantedHeight_m, .speed_m_s = kPlantedSpeed_m_s});
      prepared[i].clip = std::move(clip);
      prepared[i].made = clips[i].made;
      prepared[i].source = clips[i].source >= 0 ? clips[i].source : -1 - i;
    }
    progress->Step();
  });
  std::vector<PreparedClip> usable;
  for (size_t i = 0; i < prepared.size(); ++i) {
    if (problems[i].empty()) {
      usable.push_back(std::move(prepared[i]));
    } else {
      notes->push_back(problems[i]);
    }
  }
  return usable;
}

std::string Named(const std::string& primitive, const std::string& style) {
  return style.empty() ? primitive : primitive + " (" + style + ")";
}

// Classes with enough steady examples; what had to be left out is noted.
std::vector<StepClass> UsableClasses(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps,
                                     std::vector<std::string>* notes) {
  std::vector<StepClass> usable;
  for (StepClass& group : GroupSteps(clips, steps)) {
    const auto steady = std::count_if(group.members.begin(), group.members.end(), [&](int i) { return steps[i].steady; });
    const int needed = IsWalkStep(steps[group.members.front()]) ? kFewestSteps : kFewestStarts;
    if (steady >= needed) {
      usable.push_back(std::move(group));
    } else {
      notes->push_back(group.primitive + (group.style.empty() ? "" : " (" + group.style + ")") + ": only " +
                       std::to_string(steady) + " examples, at least " + std::to_string(needed) + " are needed; left out");
    }
  }
  return usable;
}

void NoteMissingPrimitives(const GraphContents& contents, std::vector<std::string>* notes) {
  const std::vector<std::string> wanted = {"left_" + contents.action, "right_" + contents.action, "left_first_start",
                                           "right_first_start",       "left_end",                 "right_end"};
  for (const GraphStyle& style : contents.styles) {
    for (const std::string& name : wanted) {
      const bool there = std::any_of(contents.primitives.begin(), contents.primitives.end(), [&](const MotionPrimitive& p) {
        return p.style == style.name && p.name == name;
      });
      const std::string label = name + (style.name.empty() ? "" : " (" + style.name + ")");
      const bool noted = std::any_of(notes->begin(), notes->end(),
                                     [&](const std::string& note) { return note.starts_with(label + ": only"); });
      if (!there && !noted) {
        notes->push_back(label + ": the data hold no such steps");
      }
    }
  }
}

std::vector<GraphStyle> MakeStyles(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps,
                                   const std::vector<StepClass>& classes, const PoseLayout& layout, const std::string& action) {
  std::set<std::string> names;
  for (const StepClass& group : classes) names.insert(group.style);
  std::vector<GraphStyle> styles;
  for (const std::string& name : names) {
    // Slow steps count where they would as walking steps, so that walks do not depend on what became of them, to the last bit.
    std::map<std::string, std::vector<int>> in_order;
    for (const StepClass& group : classes) {
      if (group.style != name) continue;
      for (const int i : group.members) in_order[WalkingNameOf(steps[i], action)].push_back(i);
    }
    std::vector<StepOfClip> style_steps;
    for (auto& [kind, members] : in_order) {
      std::sort(members.begin(), members.end());
      for (const int i : members) style_steps.push_back({&clips[steps[i].clip].clip, steps[i].span});
    }
    std::vector<const PreparedClip*> style_clips;
    for (const PreparedClip& clip : clips) {
      if (clip.clip.style == name) style_clips.push_back(&clip);
    }
    styles.push_back({name, MeanOverSteps(style_steps, layout), MeasureFeet(style_clips)});
  }
  return styles;
}

// Every step's class and place in it; -1 where its class was left out.
struct Membership {
  int group = -1;
  int column = 0;
};

std::vector<GraphEdge> FitEdges(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps, const std::vector<StepClass>& classes,
                                const std::vector<FittedPrimitive>& fitted, const TrainingOptions& options, Progress* progress,
                                std::vector<std::string>* notes) {
  std::vector<Membership> place(steps.size());
  for (size_t c = 0; c < classes.size(); ++c) {
    for (size_t m = 0; m < classes[c].members.size(); ++m) {
      place[classes[c].members[m]] = {static_cast<int>(c), static_cast<int>(m)};
    }
  }
  struct Pair {
    int from, to;  // columns
    const PreparedClip* clip;
  };
  std::map<std::pair<int, int>, std::vector<Pair>> pairs;  // (from, to)
  for (size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].previous < 0) continue;
    const Membership from = place[steps[i].previous];
    const Membership to = place[i];
    if (from.group < 0 || to.group < 0) continue;
    // Steps that still gather speed follow starts, and lead into ends; among steady kinds they would only disturb.
    const bool both_walk = IsWalkStep(steps[i]) && IsWalkStep(steps[steps[i].previous]);
    if (both_walk && !(steps[i].steady && steps[steps[i].previous].steady)) continue;
    pairs[{from.group, to.group}].push_back({from.column, to.column, &clips[steps[i].clip]});
  }
  std::vector<GraphEdge> edges;
  std::vector<const std::vector<Pair>*> columns;
  std::vector<double> leaving(classes.size(), 0);
  for (const auto& [ends, list] : pairs) {
    if (static_cast<int>(list.size()) < kFewestPairs) {
      const StepClass &from = classes[ends.first], &to = classes[ends.second];
      notes->push_back(Named(from.primitive, from.style) + " to " + Named(to.primitive, to.style) + ": seen " +
                       std::to_string(list.size()) + " time, at least " + std::to_string(kFewestPairs) +
                       " are needed for a transition; left out");
      continue;
    }
    edges.push_back({ends.first, ends.second, {}});
    columns.push_back(&list);
    leaving[ends.first] += static_cast<double>(list.size());
  }
  progress->Begin("transitions", 0.6, 0.95, static_cast<int>(edges.size()));
  ParallelFor(options.jobs, static_cast<int>(edges.size()), [&](int e) {
    const FittedPrimitive& from = fitted[edges[e].from];
    const FittedPrimitive& to = fitted[edges[e].to];
    const int count = static_cast<int>(columns[e]->size());
    TransitionPairs training{Eigen::MatrixXd(from.latents.rows(), count), Eigen::MatrixXd(to.latents.rows(), count), {}, {}};
    for (int i = 0; i < count; ++i) {
      const Pair& pair = (*columns[e])[i];
      training.previous.col(i) = from.latents.col(pair.from);
      training.next.col(i) = to.latents.col(pair.to);
      training.clip.push_back(pair.clip->source);
      training.made.push_back(pair.clip->made);
    }
    TransitionFitOptions fit;
    // Steps after a start still gather speed: they are not the steady ones that their primitive was learned from.
    fit.keep_marginal = IsWalking(from.primitive.start) || !IsWalking(to.primitive.end);
    edges[e].model = FitTransition(training, from.primitive.mixture, to.primitive.mixture, fit);
    edges[e].model.probability = count / leaving[edges[e].from];
    progress->Step();
  });
  return edges;
}

}  // namespace

std::shared_ptr<const MotionGraph> BuildGraph(const std::vector<TrainingClip>& clips, const TrainingOptions& options) {
  if (clips.empty()) throw DatasetError(options.name, "no clips to learn from");
  if (!options.find_keyframes && !HasKeyframeFeatures(options.action)) {
    throw DatasetError(options.name, "no key frames are known by feature for action '" + options.action +
                                         "'; name labelled examples in a manifest's \"keyframes\"");
  }
  Progress progress(options);
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

  progress.Begin("clips", 0, 0.2, static_cast<int>(clips.size()));
  const std::vector<PreparedClip> prepared = PrepareClips(clips, options, &progress, &notes);
  if (prepared.empty()) {
    throw DatasetError(options.name, "no clip is long enough to learn from" + (notes.empty() ? "" : ": " + notes.front()));
  }
  double highest_hz = 0;  // whatever the order of the clips
  for (const PreparedClip& clip : prepared) highest_hz = std::max(highest_hz, clip.clip.frame_rate_hz());
  contents.frame_rate_hz = std::min(highest_hz, kModelRate_hz);
  progress.Begin("steps", 0.2, 0.25, 1);
  std::vector<TrainingStep> steps = FindSteps(prepared, options.jobs, options.action, options.find_keyframes);
  for (std::string& note : SettleSlowSteps(prepared, options.action, kFewestStarts, &steps)) notes.push_back(std::move(note));
  const std::vector<StepClass> classes = UsableClasses(prepared, steps, &notes);
  if (classes.empty()) {
    throw DatasetError(options.name, "no kind of step has enough examples in " + std::to_string(prepared.size()) +
                                         " clips (" + std::to_string(steps.size()) + " steps found)");
  }
  progress.Step();

  contents.layout = PoseLayout(prepared.front().clip.shared_skeleton(), FindActiveJoints(prepared));
  contents.styles = MakeStyles(prepared, steps, classes, contents.layout, options.action);
  // One set of weights for all, so that classes compare.
  const Eigen::VectorXd channel_weights = contents.layout.ChannelWeights(contents.styles.front().mean_rotations);

  progress.Begin("primitives", 0.25, 0.6, static_cast<int>(classes.size()));
  std::vector<FittedPrimitive> fitted(classes.size());
  ParallelFor(options.jobs, static_cast<int>(classes.size()), [&](int c) {
    const auto style = std::find_if(contents.styles.begin(), contents.styles.end(),
                                    [&](const GraphStyle& s) { return s.name == classes[c].style; });
    fitted[c] = FitPrimitive(prepared, steps, classes[c], contents.layout, style->mean_rotations, channel_weights,
                             {.variance_kept = options.variance_kept, .seed = options.seed});
    fitted[c].primitive.style_index = static_cast<int>(style - contents.styles.begin());
    progress.Step();
  });
  contents.edges = FitEdges(prepared, steps, classes, fitted, options, &progress, &notes);
  for (FittedPrimitive& f : fitted) contents.primitives.push_back(std::move(f.primitive));

  NoteMissingPrimitives(contents, &notes);
  for (size_t p = 0; p < contents.primitives.size(); ++p) {
    const bool leaves = std::any_of(contents.edges.begin(), contents.edges.end(),
                                    [&](const GraphEdge& edge) { return edge.from == static_cast<int>(p); });
    if (!leaves) notes.push_back(Named(contents.primitives[p].name, contents.primitives[p].style) + ": dead end, no transition leaves it");
  }
  progress.Begin("model", 0.95, 1.0, 1);
  // What is returned is what a reader of the file gets, to the last bit.
  std::shared_ptr<const MotionGraph> graph = ParseModel(SerialiseModel(MotionGraph(std::move(contents), "")), options.name);
  progress.Step();
  return graph;
}

}  // namespace morphograph
