#include "api/study/study_steps.h"

#include <algorithm>

#include "datasets/errors.h"
#include "datasets/parallel_for.h"

namespace morphograph {

namespace {

constexpr size_t kQuickClasses = 4;

}  // namespace

std::string StudySteps::Name(size_t i) const {
  const StepClass& of = members(i);
  return of.style.empty() ? of.primitive : of.primitive + " (" + of.style + ")";
}

std::vector<int> StudySteps::Half(const StudyContext& context, size_t i, int half) const {
  const std::vector<int>& clips = context.half(half);
  std::vector<int> chosen;
  for (const int m : aligned[i].steady) {
    const int source = set.clips[set.steps[members(i).members[m]].clip].source;
    if (std::binary_search(clips.begin(), clips.end(), source)) chosen.push_back(m);
  }
  return chosen;
}

TrainingSet StudyTrainingSet(const StudyContext& context, StudyData data) {
  std::vector<TrainingClip> clips;
  for (const MotionClip& clip : context.clips(data)) clips.push_back({clip, false, static_cast<int>(clips.size())});
  return PrepareTrainingSet(clips, context.Training());
}

StudySteps FindStudySteps(const StudyContext& context, StudyData data) {
  const StudyOptions& options = context.options();
  StudySteps steps;
  steps.set = StudyTrainingSet(context, data);
  for (size_t c = 0; c < steps.set.classes.size(); ++c) {
    if (options.quick && steps.classes.size() == kQuickClasses) break;
    if (IsWalkStep(steps.set.steps[steps.set.classes[c].members.front()])) steps.classes.push_back(static_cast<int>(c));
  }
  if (steps.classes.empty()) throw DatasetError("study", std::string("the ") + DataName(data) + " clips hold no steps between two landings");
  steps.aligned.resize(steps.classes.size());
  ParallelFor(options.jobs, static_cast<int>(steps.classes.size()), [&](int i) {
    const StepClass& members = steps.set.classes[steps.classes[i]];
    steps.aligned[i] = AlignClass(steps.set.clips, steps.set.steps, members, steps.set.layout, StyleOf(steps.set, members).mean_rotations);
  });
  return steps;
}

}  // namespace morphograph
