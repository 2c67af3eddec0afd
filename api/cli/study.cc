#include "api/study/study.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <thread>

#include "api/cli/command.h"
#include "api/cli/progress.h"
#include "api/cli/staged_files.h"
#include "api/clip_request.h"
#include "api/study/study_json.h"
#include "api/study/study_page.h"
#include "datasets/errors.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

struct StudyFlags {
  std::vector<std::string> data, labels;
  std::string out, manifest, seed = "1";
  int jobs = 0;
  bool quick = false, quiet = false;
};

void Study(const StudyFlags& flags) {
  StudyRequest request;
  request.data.assign(flags.data.begin(), flags.data.end());
  request.labels.assign(flags.labels.begin(), flags.labels.end());
  if (!flags.manifest.empty()) request.manifest = flags.manifest;
  const std::optional<std::uint64_t> seed = ParseSeed(flags.seed);
  if (!seed) throw UsageError("--seed: '" + flags.seed + "' is not an integer from 0 to 18446744073709551615");
  request.options.seed = *seed;
  request.options.quick = flags.quick;
  request.options.jobs = flags.jobs > 0 ? flags.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));

  // First of all the folder: minutes of work should not end with the news that there is no place for it.
  const fs::path out(flags.out);
  if (fs::exists(out) && !fs::is_directory(out)) throw DatasetError(flags.out, "is a file, not a folder");
  StagedFiles files;
  files.AddFolder(out);
  StudyReport report;
  {
    ProgressLine progress(flags.quiet);
    request.options.progress = [&](const std::string& stage, double fraction) { progress.Tell(stage, fraction); };
    report = RunStudy(request);
  }
  files.Add(out / "study.json", StudyJson(report));
  files.Add(out / "index.html", StudyPage(report));
  files.Commit();
  if (flags.quiet) return;
  int figures = 0, asked = 0, hold = 0;
  for (const StudySection& section : report.sections) {
    for (const StudyFigure& figure : section.figures) {
      ++figures;
      if (!figure.at_least && !figure.at_most) continue;
      ++asked;
      if (figure.Holds()) ++hold;
    }
  }
  double all_s = 0;
  for (const auto& [part, seconds] : report.times_s) all_s += seconds;
  std::printf("%zu sections, %d figures, %d of the %d with an aim hold; %.0f s; wrote %s and %s\n", report.sections.size(), figures, hold,
              asked, all_s, (out / "index.html").c_str(), (out / "study.json").c_str());
}

}  // namespace

void AddStudy(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<StudyFlags>();
  CLI::App* verb = program->add_subcommand("study", "Run the published evaluation on recordings; writes a page and JSON");
  verb->add_option("--data", flags->data, "BVH files, and folders to search for them")->required();
  verb->add_option("--out", flags->out, "Folder for index.html and study.json")->required();
  verb->add_flag("--quick", flags->quick, "Few clips and repetitions: shows that everything runs, its figures mean little");
  verb->add_option("--labels", flags->labels, "Labelled key frames, JSON; absent: *keyframes*.json below --data");
  verb->add_option("--manifest", flags->manifest, "Describes the recordings, JSON");
  verb->add_option("--jobs", flags->jobs, "Threads; 0: one a core. The figures do not depend on it")
      ->check(CLI::Range(0, 256))->capture_default_str();
  verb->add_option("--seed", flags->seed, "Of noise, halves and samples; 64-bit unsigned integer")->capture_default_str();
  verb->add_flag("--quiet", flags->quiet, "Say nothing");
  verb->callback([flags, work] { *work = [flags] { Study(*flags); }; });
}

}  // namespace morphograph
