#include <atomic>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "api/cli/command.h"
#include "api/cli/progress.h"
#include "api/cli/staged_files.h"
#include "api/clip_request.h"
#include "api/clip_response.h"
#include "api/default_model.h"
#include "api/glb_writer.h"
#include "api/problem.h"
#include "api/variants_response.h"
#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "graph/model_io.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

struct SynthesizeFlags {
  std::string model, request, seed, out, report;
  std::optional<double> duration_s, frame_rate_hz, heading_deg;
  std::vector<double> position_m;
  std::optional<int> steps;
  std::optional<std::string> action, style, channels, unit, start_from, end;
  std::optional<int> count;
};

ClipRequest RequestFrom(const SynthesizeFlags& flags) {
  ClipRequest request;
  constexpr ClipRequestRules kRules{.model_required = false};
  if (!flags.request.empty()) {
    try {
      request = ParseClipRequest(ReadFileText(flags.request), kRules);
    } catch (const ProblemError& error) {
      throw DatasetError(flags.request, ProblemLine(error.problem()));
    }
  } else if (!flags.duration_s && !flags.steps) {
    throw UsageError("synthesize: give --duration, --steps or --request");
  }
  // Flags outrank the file; how long the clip is, is one thing said in two ways.
  if (flags.duration_s || flags.steps) {
    request.duration_s = flags.duration_s;
    request.steps = flags.steps;
  }
  if (!flags.seed.empty()) {
    request.seed = ParseSeed(flags.seed);
    if (!request.seed)
      throw UsageError("--seed: '" + flags.seed + "' is not an integer from 0 to 18446744073709551615");
  }
  if (flags.action) request.action = flags.action;
  if (flags.style) request.style = flags.style;
  if (flags.heading_deg) request.start_heading_deg = *flags.heading_deg;
  if (!flags.position_m.empty()) request.start_position_m = Eigen::Vector2d(flags.position_m[0], flags.position_m[1]);
  if (flags.start_from) request.start_from = ParseWalkBoundary(*flags.start_from).value();
  if (flags.end) request.end = ParseWalkBoundary(*flags.end).value();
  if (flags.frame_rate_hz) request.output.frame_rate_hz = flags.frame_rate_hz;
  if (flags.channels) request.output.channels = *flags.channels == "source" ? OutputChannels::kSource : OutputChannels::kPortable;
  if (flags.unit) {
    request.output.unit = *flags.unit == "m"    ? OutputUnit::kMetre
                          : *flags.unit == "cm" ? OutputUnit::kCentimetre
                                                : OutputUnit::kSource;
  }
  try {
    CheckClipRequest(request, kRules);
  } catch (const ProblemError& error) {
    if (error.problem().status == 400) throw UsageError("synthesize: " + ProblemLine(error.problem()));
    throw;
  }
  if (!request.seed) request.seed = DrawSeed();
  return request;
}

std::string ClipBytes(const MotionClip& clip, const OutputFormat& output, const fs::path& path) {
  return path.extension() == ".glb" ? WriteGlb(clip) : ClipBvh(clip, output);
}

// 0 -> "000"
std::string Numbered(int index) {
  char stem[16];
  std::snprintf(stem, sizeof stem, "%03d", index);
  return stem;
}

void AddNumbered(const SynthesizeFlags& flags, int index, const MotionClip& clip, const SynthesisReport& report, const OutputFormat& output,
                 StagedFiles* files) {
  files->Add(fs::path(flags.out) / (Numbered(index) + ".bvh"), ClipBvh(clip, output));
  if (!flags.report.empty()) files->Add(fs::path(flags.report) / (Numbered(index) + ".report.json"), ReportJson(report) + "\n");
}

// Clips of a request that asks for something: those that can be met, and what they have in common.
int AddVariants(const SynthesizeFlags& flags, const MotionGraph& graph, const ClipRequest& request, StagedFiles* files) {
  ProgressLine progress(false);
  std::atomic<int> begun = 0;
  VariantOptions options;
  options.count = *flags.count;
  options.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  options.begin = [&](int worker) {
    const double part = static_cast<double>(begun++) / options.count;
    if (worker == 0 && options.count > 20) progress.Tell("making clips", std::min(1.0, part));
    return true;
  };
  try {
    const VariantSet set = MakeVariants(graph, ToSynthesisRequest(request), options);
    for (const ClipVariant& variant : set.variants) AddNumbered(flags, variant.index, variant.clip, variant.report, request.output, files);
    files->Add(fs::path(flags.out) / "summary.json", VariantSummaryJson(set.summary) + "\n");
    return set.summary.made;
  } catch (const VariantsTooLarge& large) {
    throw UsageError(std::string("synthesize: --count: ") + large.what() + "; make them in parts, with --seed");
  }
}

void SynthesizeClips(const SynthesizeFlags& flags) {
  ClipRequest request = RequestFrom(flags);
  if (!flags.count && !flags.report.empty() && IsSameFile(flags.out, flags.report))
    throw UsageError("synthesize: --out and --report name the same file");
  const std::shared_ptr<const MotionGraph> graph = flags.model.empty() ? LoadDefaultModel() : LoadModel(flags.model);
  if (!graph) throw UsageError("synthesize: this program was built without a default model; give --model");
  // With --model the file's "model" is a name that some server knows it by.
  if (flags.model.empty() && !request.model.empty() && request.model != graph->name())
    throw DatasetError(flags.request, "/model: asks for '" + request.model + "'; give its file by --model");

  StagedFiles files;
  const std::uint64_t first_seed = *request.seed;
  if (!flags.count) {
    const SynthesisResult clip = Synthesize(*graph, ToSynthesisRequest(request));
    files.Add(flags.out, ClipBytes(clip.clip, request.output, flags.out));
    if (!flags.report.empty()) files.Add(flags.report, ReportJson(clip.report) + "\n");
  } else {
    files.AddFolder(flags.out);
    if (!flags.report.empty()) files.AddFolder(flags.report);
  }
  int made = flags.count.value_or(1);
  if (flags.count && !request.control.empty()) {
    made = AddVariants(flags, *graph, request, &files);
  } else if (flags.count) {
    ProgressLine progress(false);
    for (int i = 0; i < *flags.count; ++i) {
      if (*flags.count > 20) progress.Tell("making clips", static_cast<double>(i) / *flags.count);
      request.seed = first_seed + static_cast<std::uint64_t>(i);  // goes on at 0 after 2^64 - 1
      const SynthesisResult clip = Synthesize(*graph, ToSynthesisRequest(request));
      AddNumbered(flags, i, clip.clip, clip.report, request.output, &files);
    }
  }
  files.Commit();
  std::cout << "wrote " << flags.out << ", seed " << first_seed;
  if (flags.count) std::cout << " and on, " << made << " clips";
  if (flags.count && made < *flags.count) std::cout << "; of " << *flags.count - made << " seeds the request cannot be met";
  std::cout << '\n';
}

}  // namespace

void AddSynthesize(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<SynthesizeFlags>();
  CLI::App* verb = program->add_subcommand("synthesize", "Make new clips from a model");
  verb->add_option("--model", flags->model, "Model file; the embedded model when absent");
  CLI::Option* duration = verb->add_option("--duration", flags->duration_s, "Length, seconds");
  verb->add_option("--steps", flags->steps, "Length, steps")->excludes(duration);
  verb->add_option("--request", flags->request, "Clip request, JSON as for POST /v1/clips; flags outrank it");
  verb->add_option("--seed", flags->seed, "64-bit unsigned integer; drawn when absent");
  verb->add_option("--count", flags->count, "Clips to make, with seeds N, N+1, ...; --out is a folder then")
      ->check(CLI::Range(1, 1'000'000));
  verb->add_option("--action", flags->action, "One of the model's actions; its own when absent");
  verb->add_option("--style", flags->style, "One of the styles of that action");
  verb->add_option("--start", flags->position_m, "Start on the floor: X Z, metres")->expected(2);
  verb->add_option("--heading", flags->heading_deg, "Start heading, degrees; 0 faces +Z, 90 faces +X");
  const CLI::IsMember boundary({"walking", "slow_step", "standing"});
  verb->add_option("--start-from", flags->start_from, "What the clip begins out of: walking, slow_step or standing")->check(boundary);
  verb->add_option("--end", flags->end, "What it ends in: walking, slow_step or standing")->check(boundary);
  verb->add_option("--frame-rate", flags->frame_rate_hz, "Frames per second; the model's own when absent");
  verb->add_option("--channels", flags->channels, "portable or source")->check(CLI::IsMember({"portable", "source"}));
  verb->add_option("--unit", flags->unit, "m, cm or source")->check(CLI::IsMember({"m", "cm", "source"}));
  verb->add_option("--out", flags->out, "File (.bvh or .glb), or folder with --count")->required();
  verb->add_option("--report", flags->report, "Where the report goes: a file, or a folder with --count");
  verb->callback([flags, work] { *work = [flags] { SynthesizeClips(*flags); }; });
}

}  // namespace morphograph
