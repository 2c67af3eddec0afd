#include "graph/training_set.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "graph/internal/training_progress.h"
#include "primitives/keyframe_detector.h"

namespace morphograph {
namespace {

// Steps are sampled at some 30 Hz; more than this only costs time.
constexpr double kWorkRate_hz = 60;
constexpr double kSlowestRate_hz = 10;  // below, a step has fewer than five frames
constexpr int kFewestSteps = 4;   // of a steady kind, to be worth a primitive
constexpr int kFewestStarts = 2;  // of a start or an end, of which captures hold few
// Contact labels say where a foot may be held, so they are stricter than what counts as a contact elsewhere: a foot that rolls
// off at half a metre a second must not be held.
constexpr double kPlantedHeight_m = 0.04;
constexpr double kPlantedSpeed_m_s = 0.35;

// Every clip on the skeleton of the first one, at a rate that is worth its work.
std::vector<PreparedClip> PrepareClips(const std::vector<TrainingClip>& clips, const TrainingOptions& options, TrainingProgress* progress,
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
      if (clips[i].other_action != options.action) prepared[i].other_action = clips[i].other_action;
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
      notes->push_back(NameInNotes(group.primitive, group.style, group.other_action) + ": only " +
                       std::to_string(steady) + " examples, at least " + std::to_string(needed) + " are needed; left out");
    }
  }
  return usable;
}

std::vector<GraphStyle> MakeStyles(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps,
                                   const std::vector<StepClass>& classes, const PoseLayout& layout, const std::string& action) {
  std::set<std::pair<std::string, std::string>> names;
  for (const StepClass& group : classes) names.insert({group.other_action, group.style});
  std::vector<GraphStyle> styles;
  for (const auto& [other_action, name] : names) {
    // Slow steps count where they would as walking steps, so that walks do not depend on what became of them, to the last bit.
    std::map<std::string, std::vector<int>> in_order;
    for (const StepClass& group : classes) {
      if (group.style != name || group.other_action != other_action) continue;
      for (const int i : group.members) in_order[WalkingNameOf(steps[i], clips[steps[i].clip].ActionOr(action))].push_back(i);
    }
    std::vector<StepOfClip> style_steps;
    for (auto& [kind, members] : in_order) {
      std::sort(members.begin(), members.end());
      for (const int i : members) style_steps.push_back({&clips[steps[i].clip].clip, steps[i].span});
    }
    std::vector<const PreparedClip*> style_clips;
    for (const PreparedClip& clip : clips) {
      if (clip.clip.style == name && clip.other_action == other_action) style_clips.push_back(&clip);
    }
    // One set of means for all actions of a style, so that steps of one can be mixed with those of another.
    const auto usual = std::find_if(styles.begin(), styles.end(), [&](const GraphStyle& s) { return s.name == name; });
    styles.push_back({name, usual != styles.end() ? usual->mean_rotations : MeanOverSteps(style_steps, layout),
                      MeasureFeet(style_clips), other_action});
  }
  return styles;
}

}  // namespace

const GraphStyle& StyleOf(const TrainingSet& set, const StepClass& members) {
  for (const GraphStyle& style : set.styles) {
    if (style.name == members.style && style.other_action == members.other_action) return style;
  }
  throw std::out_of_range("StyleOf: the set has no style '" + members.style + "'");
}

TrainingSet PrepareTrainingSet(const std::vector<TrainingClip>& clips, const TrainingOptions& options, TrainingProgress* progress) {
  if (clips.empty()) throw DatasetError(options.name, "no clips to learn from");
  if (!options.find_keyframes && !HasKeyframeFeatures(options.action)) {
    throw DatasetError(options.name, "no key frames are known by feature for action '" + options.action +
                                         "'; name labelled examples in a manifest's \"keyframes\"");
  }
  for (const TrainingClip& clip : clips) {
    if (clip.other_action.empty() || clip.other_action == options.action || HasKeyframeFeatures(clip.other_action)) continue;
    throw DatasetError(clip.clip.name, "no key frames are known by feature for action '" + clip.other_action + "'");
  }
  TrainingProgress unheard(options);
  if (!progress) progress = &unheard;
  TrainingSet set;
  progress->Begin("clips", 0, 0.2, static_cast<int>(clips.size()));
  set.clips = PrepareClips(clips, options, progress, &set.notes);
  if (set.clips.empty()) {
    throw DatasetError(options.name, "no clip is long enough to learn from" + (set.notes.empty() ? "" : ": " + set.notes.front()));
  }
  progress->Begin("steps", 0.2, 0.25, 1);
  if (!options.variant.styles) {
    for (PreparedClip& clip : set.clips) clip.clip.style.clear();
  }
  set.steps = FindSteps(set.clips, options.jobs, options.action, options.find_keyframes);
  for (std::string& note : SettleSlowSteps(set.clips, options.action, kFewestStarts, &set.steps)) set.notes.push_back(std::move(note));
  set.classes = UsableClasses(set.clips, set.steps, &set.notes);
  if (set.classes.empty()) {
    throw DatasetError(options.name, "no kind of step has enough examples in " + std::to_string(set.clips.size()) +
                                         " clips (" + std::to_string(set.steps.size()) + " steps found)");
  }
  progress->Step();

  set.layout = PoseLayout(set.clips.front().clip.shared_skeleton(), FindActiveJoints(set.clips),
                          options.variant.euler ? RotationForm::kEuler : RotationForm::kLogMap);
  set.styles = MakeStyles(set.clips, set.steps, set.classes, set.layout, options.action);
  set.channel_weights = options.variant.weighted ? set.layout.ChannelWeights(set.styles.front().mean_rotations)
                                                 : Eigen::VectorXd::Ones(set.layout.channels());
  return set;
}

}  // namespace morphograph
