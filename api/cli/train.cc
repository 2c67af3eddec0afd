#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <thread>

#include "api/cli/command.h"
#include "api/cli/progress.h"
#include "api/cli/staged_files.h"
#include "api/model_description.h"
#include "api/training.h"
#include "datasets/text_encoding.h"
#include "graph/graph_summary.h"
#include "graph/model_io.h"

namespace morphograph {
namespace {

struct TrainFlags {
  std::vector<std::string> data;
  std::string out, name, action, manifest, report;
  int jobs = 0;
  bool quiet = false;
  bool no_recordings = false;
};

// The command as it can be given again; paths by their last part, so that a model does not tell of its maker's folders.
std::string CommandOf(const TrainFlags& flags) {
  const auto last = [](const std::string& path) {
    const std::filesystem::path whole(path);
    return (whole.has_filename() ? whole.filename() : whole.parent_path().filename()).string();
  };
  std::string command = "morphograph train --data";
  for (const std::string& path : flags.data) command += " " + last(path);
  command += " --out " + last(flags.out);
  if (!flags.action.empty()) command += " --action " + flags.action;
  if (!flags.manifest.empty()) command += " --manifest " + last(flags.manifest);
  if (!flags.name.empty()) command += " --name " + flags.name;
  if (flags.no_recordings) command += " --no-recordings";
  return Utf8FromUnknown(command);
}

void TrainModel(const TrainFlags& flags) {
  if (!flags.name.empty() && !IsModelName(flags.name))
    throw UsageError("--name: must be 1 to 64 letters, digits, '.', '_' or '-', the first a letter or digit");
  const std::filesystem::path report_folder(flags.report);
  for (const char* name : {"training.json", "graph.dot"}) {
    if (!flags.report.empty() && IsSameFile(flags.out, report_folder / name))
      throw UsageError("train: --out names a file of --report, " + std::string(name));
  }
  TrainingRequest request;
  request.data.assign(flags.data.begin(), flags.data.end());
  if (!flags.manifest.empty()) request.manifest = flags.manifest;
  request.name = flags.name;
  if (!flags.action.empty()) request.action = flags.action;
  request.jobs = flags.jobs > 0 ? flags.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  request.command = CommandOf(flags);
  request.keep_recordings = !flags.no_recordings;

  TrainingOutcome outcome;
  {
    ProgressLine progress(flags.quiet);
    request.progress = [&](const std::string& stage, double fraction) { progress.Tell(stage, fraction); };
    outcome = Train(request);
  }
  const GraphSummary summary = Summarise(*outcome.graph);
  const std::string model = SerialiseModel(*outcome.graph);
  StagedFiles files;
  files.Add(flags.out, model);
  if (!flags.report.empty()) {
    files.AddFolder(report_folder);
    files.Add(report_folder / "training.json", TrainingReportJson(outcome) + "\n");
    files.Add(report_folder / "graph.dot", GraphDot(summary));
  }
  files.Commit();
  if (flags.quiet) return;
  std::cout << GraphText(summary);
  for (const std::string& note : outcome.notes) std::cout << "- " << note << '\n';
  std::printf("\nread %d clips in %.1f s, added %d made ones, learned in %.1f s; wrote %s, %.2f MB\n", outcome.clips,
              outcome.read_s, outcome.made, outcome.learn_s, flags.out.c_str(), 1e-6 * static_cast<double>(model.size()));
}

}  // namespace

void AddTrain(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<TrainFlags>();
  CLI::App* verb = program->add_subcommand("train", "Learn a model from motion capture");
  verb->add_option("--data", flags->data, "BVH files, and folders to search for them")->required();
  verb->add_option("--out", flags->out, "Model file to write")->required();
  verb->add_option("--action", flags->action, "What is learned; the manifest's, else walk");
  verb->add_option("--name", flags->name, "What the model is called; the manifest's name, else the action");
  verb->add_option("--manifest", flags->manifest, "Describes the recordings, JSON");
  verb->add_option("--jobs", flags->jobs, "Threads; 0: one a core. The result does not depend on it")
      ->check(CLI::Range(0, 256))->capture_default_str();
  verb->add_option("--report", flags->report, "Folder for training.json and graph.dot");
  verb->add_flag("--no-recordings", flags->no_recordings, "Leave the recordings out of the model: a fifth of the size, but less to reconstruct from");
  verb->add_flag("--quiet", flags->quiet, "Say nothing");
  verb->callback([flags, work] { *work = [flags] { TrainModel(*flags); }; });
}

}  // namespace morphograph
