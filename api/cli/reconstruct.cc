#include <iostream>
#include <memory>
#include <numbers>
#include <thread>

#include "api/cli/command.h"
#include "api/cli/staged_files.h"
#include "api/clip_response.h"
#include "api/default_model.h"
#include "api/glb_writer.h"
#include "api/problem.h"
#include "api/reconstruction_report.h"
#include "api/reconstruction_stream.h"
#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/readings_reader.h"
#include "datasets/resample.h"
#include "graph/model_io.h"

namespace morphograph {
namespace {

struct ReconstructFlags {
  std::string model, method, input, placements, out, report, truth, channels = "portable", unit = "source";
  double frame_rate_hz = 0, low_pass_hz = 0;
  int jobs = 0;
  bool stream = false, align = false;
  std::vector<double> standing_s;  // from, to
};

OutputFormat FormatOf(const ReconstructFlags& flags) {
  OutputFormat format;
  format.channels = flags.channels == "source" ? OutputChannels::kSource : OutputChannels::kPortable;
  format.unit = flags.unit == "m" ? OutputUnit::kMetre : flags.unit == "cm" ? OutputUnit::kCentimetre : OutputUnit::kSource;
  return format;
}

ReconstructionQuality ErrorsAgainst(const ReconstructFlags& flags, const MotionClip& clip) {
  const MotionClip truth = ImportClip(ReadBvhFile(flags.truth));
  try {
    return CompareClips(clip, truth);
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(flags.truth, ReasonOf(unfit));
  }
}

// Lines of readings from standard input, lines of poses to standard output.
void ReconstructLive(const ReconstructFlags& flags, const std::shared_ptr<const MotionGraph>& graph) {
  const ReconstructionMethod method = ParseMethod(flags.method).value();
  const std::vector<Placement> placements = ReadPlacements(flags.placements);
  const int jobs = flags.jobs > 0 ? flags.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  ReconstructionStream stream(MakeReconstructor(graph, method, placements, jobs));
  std::string line;
  int number = 0;
  const auto write = [&](auto lines) {
    try {
      std::cout << lines() << std::flush;
    } catch (const ProblemError& error) {
      throw DatasetError("standard input", number, 0, ProblemLine(error.problem()));
    }
  };
  while (std::getline(std::cin, line)) {
    ++number;
    write([&] { return stream.Push(line); });
  }
  write([&] { return stream.Finish(); });
}

void Reconstruct(const ReconstructFlags& flags) {
  if (flags.stream ? flags.placements.empty() || !flags.input.empty() || !flags.out.empty() : flags.input.empty() || flags.out.empty())
    throw UsageError(flags.stream ? "reconstruct: --stream takes --placements, and neither --input nor --out" : "reconstruct: give --input and --out, or --stream");
  if (flags.stream && (!flags.report.empty() || !flags.truth.empty() || flags.low_pass_hz > 0))
    throw UsageError("reconstruct: --report, --truth and --low-pass need all readings at once; with --stream what was lost stands in the lines' \"notes\"");
  if (flags.stream && flags.align) throw UsageError("reconstruct: --align needs all readings at once; it does not go with --stream");
  if (!flags.standing_s.empty() && !(flags.standing_s[0] < flags.standing_s[1])) throw UsageError("reconstruct: --standing must end after it begins");
  if (!flags.report.empty() && IsSameFile(flags.out, flags.report)) throw UsageError("reconstruct: --out and --report name the same file");
  const std::shared_ptr<const MotionGraph> graph = flags.model.empty() ? LoadDefaultModel() : LoadModel(flags.model);
  if (!graph) throw UsageError("reconstruct: this program was built without a default model; give --model");
  if (flags.stream) return ReconstructLive(flags, graph);
  ReconstructionRequest request;
  request.method = ParseMethod(flags.method).value();
  request.source = flags.input;
  RecordedReadings recorded = ReadReadings(flags.input);
  const bool markers = request.method == ReconstructionMethod::kMarkers;
  if (recorded.kind && (*recorded.kind == ReadingsKind::kMarkers) != markers) {
    throw DatasetError(flags.input, markers ? "holds accelerations; --method markers takes positions of markers"
                                            : "holds positions of markers; --method " + flags.method + " takes accelerations");
  }
  request.readings = std::move(recorded.readings);
  request.low_pass_hz = flags.low_pass_hz;
  if (flags.align) request.alignment.emplace();
  if (!flags.standing_s.empty()) request.alignment->standing = StandingPhase{flags.standing_s[0], flags.standing_s[1]};
  if (!flags.placements.empty()) request.placements = ReadPlacements(flags.placements);
  const int jobs = flags.jobs > 0 ? flags.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  ReconstructedReadings made = ReconstructReadings(
      *graph, request, [&](const std::vector<Placement>& sensors) { return MakeReconstructor(graph, request.method, sensors, jobs); });
  made.repaired.notes.insert(made.repaired.notes.begin(), recorded.notes.begin(), recorded.notes.end());
  std::optional<ReconstructionQuality> errors;
  if (!flags.truth.empty()) errors = ErrorsAgainst(flags, made.reconstruction.clip);
  MotionClip clip = flags.frame_rate_hz > 0 ? Resample(made.reconstruction.clip, flags.frame_rate_hz) : made.reconstruction.clip;

  StagedFiles files;
  files.Add(flags.out, std::filesystem::path(flags.out).extension() == ".glb" ? WriteGlb(clip) : ClipBvh(clip, FormatOf(flags)));
  if (!flags.report.empty()) files.Add(flags.report, ReconstructionReportJson(request.method, made, errors) + "\n");
  files.Commit();
  std::cout << "wrote " << flags.out << ", " << clip.frame_count() << " frames\n";
  for (const std::string& note : made.repaired.notes) std::cout << "- " << note << '\n';
  if (made.alignment) {
    std::printf("aligned by standing from %.2f to %.2f s:", made.alignment->standing.from_s, made.alignment->standing.to_s);
    for (std::size_t s = 0; s < made.sensors.size(); ++s) std::printf("%s %s by %.0f degrees", s == 0 ? "" : ",", made.sensors[s].c_str(), made.alignment->sensors[s].turn_rad() * 180 / std::numbers::pi);
    std::printf("\n");
  }
  if (errors) std::printf("joints off by %.2f cm on the average, 95 %% of frames within %.2f cm\n", errors->position_rms_cm, errors->position_rms_p95_cm);
}

}  // namespace

void AddReconstruct(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<ReconstructFlags>();
  CLI::App* verb = program->add_subcommand("reconstruct", "Make a clip of what a few accelerometers or markers read");
  verb->add_option("--model", flags->model, "Model file; the embedded model when absent");
  verb->add_option("--method", flags->method, "graph, olng, olng_kernels, rbf, rbf_lle or gaussian of accelerations, markers of marker positions")
      ->required()
      ->check(CLI::IsMember({"graph", "olng", "olng_kernels", "rbf", "rbf_lle", "gaussian", "markers"}));
  verb->add_option("--input", flags->input, "Readings: CSV (time,<sensor>.x,<sensor>.y,<sensor>.z,...), TRC, raw sensor files");
  verb->add_option("--placements", flags->placements, "Where the sensors sit, JSON; absent: at the joints that they are called after");
  verb->add_option("--out", flags->out, "File (.bvh or .glb)");
  verb->add_flag("--stream", flags->stream, "Readings as lines of JSON on standard input, poses as lines of JSON on standard output, frame by frame");
  CLI::Option* align = verb->add_flag("--align", flags->align, "Find how the sensors sit from a stretch of the readings in which their wearer stands");
  verb->add_option("--standing", flags->standing_s, "With --align: when that is, FROM,TO in seconds of the readings' time; found when absent")->delimiter(',')->expected(2)->needs(align);
  verb->add_option("--low-pass", flags->low_pass_hz, "Smooth the readings first: cut-off in Hz; none when absent")->check(CLI::Range(0.5, 1000.0));
  verb->add_option("--report", flags->report, "Where the report goes");
  verb->add_option("--truth", flags->truth, "BVH of the true motion, to tell errors against");
  verb->add_option("--frame-rate", flags->frame_rate_hz, "Frames per second of the clip; 30 when absent")->check(CLI::Range(1.0, 240.0));
  verb->add_option("--channels", flags->channels, "portable or source")->check(CLI::IsMember({"portable", "source"}));
  verb->add_option("--unit", flags->unit, "m, cm or source")->check(CLI::IsMember({"m", "cm", "source"}));
  verb->add_option("--jobs", flags->jobs, "Threads; 0: one a core. The result does not depend on it")->check(CLI::Range(0, 256));
  verb->callback([flags, work] { *work = [flags] { Reconstruct(*flags); }; });
}

}  // namespace morphograph
