#include "api/training.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "api/keyframe_examples.h"
#include "api/model_description.h"
#include "datasets/augmentation.h"
#include "datasets/errors.h"
#include "datasets/manifest.h"
#include "graph/graph_builder.h"
#include "primitives/keyframe_detector.h"
#include "primitives/keyframe_labels.h"

namespace morphograph {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

bool IsModelName(std::string_view name) {
  if (name.empty() || name.size() > 64) return false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!word && (i == 0 || (c != '.' && c != '_' && c != '-'))) return false;
  }
  return true;
}

TrainingSubject CheckTraining(const std::string& name, const std::optional<std::string>& action, const DatasetManifest& manifest,
                              bool has_labels) {
  // What the caller asked for is wrong usage; what the manifest says is bad data.
  const auto fail = [&](bool asked, const char* pointer, const std::string& detail) {
    if (asked) throw TrainingUsageError(pointer, detail);
    throw DatasetError(manifest.file.empty() ? "training" : manifest.file, std::string(pointer) + ": " + detail);
  };
  TrainingSubject subject;
  subject.action = action.value_or(manifest.action);
  subject.name = !name.empty() ? name : !manifest.name.empty() ? manifest.name : subject.action;
  if (!has_labels && !HasKeyframeFeatures(subject.action)) {
    fail(action.has_value(), "/action",
         "'" + subject.action + "' has no key frames by feature (walk and run have); labelled examples make it possible, see the "
         "manifest's \"keyframes\"");
  }
  for (const auto& [other, patterns] : manifest.actions) {
    if (other == subject.action) continue;  // asked for as the model's own
    if (!HasKeyframeFeatures(other)) {
      fail(false, "/actions", "'" + other + "' has no key frames by feature (walk and run have)");
    }
  }
  if (!IsModelName(subject.action)) {
    fail(action.has_value(), "/action", "'" + subject.action + "' cannot name an action");
  }
  if (!IsModelName(subject.name)) fail(!name.empty(), "/name", "'" + subject.name + "' cannot name a model");
  return subject;
}

TrainingOutcome Train(const TrainingRequest& request) {
  DatasetManifest manifest;
  if (request.manifest) manifest = ReadManifest(*request.manifest);
  if (request.keyframe_labels) manifest.keyframe_examples = *request.keyframe_labels;
  TrainingOptions options;
  const bool has_labels = !manifest.keyframe_examples.empty();
  const TrainingSubject subject = CheckTraining(request.name, request.action, manifest, has_labels);
  options.name = subject.name;
  options.action = subject.action;
  LabelledClips labels;
  if (has_labels) labels = ReadKeyframeLabels(manifest.keyframe_examples);
  options.jobs = request.jobs;
  options.keep_recordings = request.keep_recordings;
  options.source = manifest.source;
  options.licence = manifest.licence;
  options.attribution = manifest.attribution;
  options.command = request.command;
  options.cancelled = request.cancelled;
  constexpr double kReading = 0.1;  // about this part of the work
  const auto tell = [&](const std::string& stage, double fraction) {
    if (request.progress) request.progress(stage, fraction);
  };
  options.progress = [&](const std::string& stage, double fraction) {
    tell(stage, kReading + (1 - kReading) * fraction);
  };

  TrainingOutcome outcome;
  tell("reading clips", 0);
  auto started = Clock::now();
  Dataset dataset = LoadDataset(request.data, manifest, request.jobs, request.limits);
  outcome.clips = static_cast<int>(dataset.clips.size());
  outcome.notes = dataset.notes;
  for (const SkippedClip& skipped : dataset.skipped)
    outcome.notes.push_back(skipped.file.filename().string() + " left out: " + skipped.reason);
  MatchedLabels matched;
  const std::string labels_file = manifest.keyframe_examples.string();
  if (has_labels) matched = MatchLabels(labels, dataset.clips, labels_file);
  outcome.notes.insert(outcome.notes.end(), matched.notes.begin(), matched.notes.end());
  std::vector<MotionClip> read;
  std::vector<std::string> other_actions;
  for (LoadedClip& loaded : dataset.clips) {
    if (!loaded.note.empty()) outcome.notes.push_back(loaded.clip.name + ": " + loaded.note);
    read.push_back(std::move(loaded.clip));
    other_actions.push_back(loaded.other_action);
  }
  if (has_labels) options.find_keyframes = LearnKeyframes(read, matched.frames, labels_file);
  std::vector<TrainingClip> clips;
  int source = -1;
  for (AugmentedClip& augmented : Augment(read, AugmentationOf(manifest), request.jobs)) {
    if (!augmented.made) ++source;  // its copies follow
    clips.push_back({std::move(augmented.clip), augmented.made, source, other_actions.at(static_cast<std::size_t>(source))});
  }
  outcome.made = static_cast<int>(clips.size()) - outcome.clips;
  outcome.read_s = SecondsSince(started);
  if (request.cancelled && *request.cancelled) throw TrainingCancelled();

  started = Clock::now();
  outcome.graph = BuildGraph(clips, options);
  outcome.learn_s = SecondsSince(started);
  return outcome;
}

std::string TrainingReportJson(const TrainingOutcome& outcome) {
  const GraphSummary summary = Summarise(*outcome.graph);
  nlohmann::ordered_json json = {{"clips", outcome.clips},
                                 {"made_clips", outcome.made},
                                 {"read_seconds", outcome.read_s},
                                 {"learn_seconds", outcome.learn_s},
                                 {"notes", outcome.notes},
                                 {"starts_and_ends", StartsAndEndsJson(summary)},
                                 {"model", GraphJson(summary, summary.name)}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace morphograph
