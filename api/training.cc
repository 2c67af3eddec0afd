#include "api/training.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "api/model_description.h"
#include "datasets/augmentation.h"
#include "datasets/errors.h"
#include "datasets/manifest.h"
#include "graph/graph_builder.h"

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

TrainingOutcome Train(const TrainingRequest& request) {
  DatasetManifest manifest;
  if (request.manifest) manifest = ReadManifest(*request.manifest);
  TrainingOptions options;
  options.action = request.action.value_or(manifest.action);
  options.name = !request.name.empty() ? request.name : !manifest.name.empty() ? manifest.name : options.action;
  if (!IsModelName(options.name))
    throw DatasetError(request.manifest ? request.manifest->string() : "training", "'" + options.name + "' cannot name a model");
  options.jobs = request.jobs;
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
  std::vector<MotionClip> read;
  for (LoadedClip& loaded : dataset.clips) {
    if (!loaded.note.empty()) outcome.notes.push_back(loaded.clip.name + ": " + loaded.note);
    read.push_back(std::move(loaded.clip));
  }
  std::vector<TrainingClip> clips;
  int source = -1;
  for (AugmentedClip& augmented : Augment(read, AugmentationOf(manifest), request.jobs)) {
    if (!augmented.made) ++source;  // its copies follow
    clips.push_back({std::move(augmented.clip), augmented.made, source});
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
