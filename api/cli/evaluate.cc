#include <cstdio>
#include <iostream>
#include <memory>

#include "api/cli/command.h"
#include "api/cli/progress.h"
#include "api/evaluation_response.h"
#include "datasets/dataset_loader.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

struct EvaluateFlags {
  std::vector<std::string> clips;
  std::string reference;
  bool json = false;
};

std::vector<MotionClip> Load(const std::vector<fs::path>& paths, std::vector<int>* first_frames = nullptr) {
  std::vector<MotionClip> clips;
  Dataset dataset = LoadDataset(paths);
  for (LoadedClip& loaded : dataset.clips) {
    clips.push_back(std::move(loaded.clip));
    if (first_frames) first_frames->push_back(loaded.first_frame);
  }
  return clips;
}

void PrintHeader() {
  std::printf("%-32s %7s %8s %12s %12s %12s %12s\n", "clip", "frames", "seconds", "contact mm", "skate cm/s",
              "below mm", "naturalness");
}

void PrintRow(const MotionClip& clip, const ClipQuality& quality) {
  std::printf("%-32s %7d %8.2f %12.2f %12.2f %12.2f %12.4g\n", clip.name.c_str(), clip.frame_count(), clip.duration_s(),
              1000 * quality.contact_distance_m, quality.foot_skate_cm_s, 1000 * quality.penetration_m,
              quality.naturalness);
}

void PrintComparison(const SetComparison& c) {
  std::printf("\nagainst the reference: Frechet distance %.4g, %.2f times that between its random halves (%.4g)\n",
              c.frechet, c.frechet_ratio, c.frechet_halves);
  std::printf("outside of the reference's leading directions %.2f times as much as the reference itself\n", c.residual_ratio);
  std::printf("diversity %.4g, of the reference %.4g; %d and %d windows\n", c.diversity, c.diversity_reference, c.windows,
              c.windows_reference);
}

void Evaluate(const EvaluateFlags& flags) {
  // Everything is computed before anything is printed: a failure prints no half result.
  std::vector<int> first_frames;
  const std::vector<MotionClip> clips = Load({flags.clips.begin(), flags.clips.end()}, &first_frames);
  std::vector<ClipEvaluation> evaluations;
  for (const MotionClip& clip : clips) {
    try {
      evaluations.push_back(EvaluateClip(clip));
    } catch (const std::invalid_argument& unfit) {
      throw DatasetError(clip.name, "cannot be evaluated: " + ReasonOf(unfit));
    }
  }
  std::optional<SetComparison> comparison;
  std::string problem;  // why there is none: a set may be too small to be compared, and its clips are judged all the same
  if (!flags.reference.empty()) {
    const std::vector<MotionClip> reference = Load({flags.reference});
    try {
      comparison = CompareSets(clips, reference);
    } catch (const std::invalid_argument& unfit) {
      problem = ReasonOf(unfit);
    }
  }
  if (!flags.json) PrintHeader();
  for (std::size_t i = 0; i < clips.size(); ++i) {
    if (!flags.json) {
      PrintRow(clips[i], evaluations[i].quality);
      continue;
    }
    nlohmann::ordered_json json = EvaluationJson(clips[i], evaluations[i], first_frames[i]);
    if (comparison) {
      json["reference"] = ComparisonJson(*comparison);
    } else if (!problem.empty()) {
      json["reference"] = nullptr;
      json["reference_problem"] = problem;
    }
    std::cout << json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  }
  if (!flags.json && comparison) PrintComparison(*comparison);
  if (!flags.json && !problem.empty()) std::printf("\nnot compared with the reference: %s\n", problem.c_str());
}

}  // namespace

void AddEvaluate(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<EvaluateFlags>();
  CLI::App* verb = program->add_subcommand("evaluate", "Judge clips: contacts, skate, naturalness");
  verb->add_option("clips", flags->clips, "BVH files and folders")->required();
  verb->add_option("--reference", flags->reference, "Folder of captured clips to compare the set with");
  verb->add_flag("--json", flags->json, "One JSON object a clip, a line each; with --reference, its member \"reference\" is of the whole set");
  verb->callback([flags, work] { *work = [flags] { Evaluate(*flags); }; });
}

}  // namespace morphograph
