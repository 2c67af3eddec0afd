#include "api/reconstruction_request.h"

#include "api/json_guard.h"
#include "api/request/object_reader.h"
#include "api/request/output_reader.h"
#include "api/request/readings_reader.h"

namespace morphograph {

namespace {

AlignmentRequest ReadAlignment(const nlohmann::json& object, Findings* findings) {
  constexpr double kFarthest_s = 1e9;
  AlignmentRequest alignment;
  ObjectReader reader(object, "/alignment", findings);
  if (const nlohmann::json* standing = reader.List("standing", 2, 2, "times in seconds, [from, to]")) {
    const auto time = [&](std::size_t i) { return ReadBounded((*standing)[i], reader.At("standing") + "/" + std::to_string(i), {-kFarthest_s, kFarthest_s, "s"}, findings); };
    const std::optional<double> from_s = time(0), to_s = time(1);
    if (from_s && to_s && !(*from_s < *to_s)) findings->Malformed(reader.At("standing"), "must end after it begins");
    if (from_s && to_s) alignment.standing = StandingPhase{*from_s, *to_s};
  }
  reader.RefuseOthers();
  return alignment;
}

}  // namespace

ReconstructionBody ParseReconstructionBody(std::string_view text) {
  const nlohmann::json document = ParseUntrustedJson(text);
  Findings findings("the reconstruction request");
  ReconstructionBody body;
  if (!document.is_object()) {
    findings.Malformed("", std::string("must be an object, not ") + document.type_name());
    findings.ThrowIfAny();
  }
  ObjectReader reader(document, "", &findings);
  body.model = reader.Required("model", reader.Text("model"), "the name of a model that is served").value_or("");
  const auto method = ParseMethod(reader.Text("method").value_or("graph"));
  if (!method) findings.Malformed("/method", "must be \"graph\", \"olng\", \"olng_kernels\", \"rbf\", \"rbf_lle\", \"gaussian\" or \"markers\"");
  body.request.method = method.value_or(ReconstructionMethod::kGraph);
  if (const nlohmann::json* sensors = reader.Object("sensors")) {
    PlacedReadings placed = ReadPlacedReadings(*sensors, "/sensors", &findings);
    body.request.readings = std::move(placed.readings);
    body.request.placements = std::move(placed.placements);
  } else if (!reader.Has("sensors")) {
    findings.Malformed("/sensors", "required: rate, placements and readings");
  }
  if (const nlohmann::json* alignment = reader.Object("alignment")) body.request.alignment = ReadAlignment(*alignment, &findings);
  if (reader.Has("low_pass")) body.request.low_pass_hz = reader.Bounded("low_pass", {0.5, 1000, "Hz"}).value_or(0);
  body.request.source = "/sensors/readings";
  if (const nlohmann::json* output = reader.Object("output")) {
    body.output = ReadOutputFormat(*output, &findings);
    const auto rate_hz = body.output.frame_rate_hz;
    if (rate_hz && !(*rate_hz >= kMinFrameRate_hz && *rate_hz <= kMaxFrameRate_hz))
      findings.Unmeetable("/output/frame_rate", "from " + NumberText(kMinFrameRate_hz) + " to " + NumberText(kMaxFrameRate_hz) + " frames per second");
  }
  reader.RefuseOthers();
  findings.ThrowIfAny();
  const std::vector<double>& times = body.request.readings.times_s;
  if (times.back() - times.front() > kMaxDuration_s)
    findings.Unmeetable("/sensors/readings", "at most " + NumberText(kMaxDuration_s) + " seconds at a time");
  findings.ThrowIfAny();
  return body;
}

StreamHead ParseStreamHead(std::string_view text) {
  const nlohmann::json document = ParseUntrustedJson(text);
  Findings findings("the first line");
  StreamHead head;
  if (!document.is_object()) {
    findings.Malformed("", "must be an object with \"model\", \"method\" and \"placements\"");
    findings.ThrowIfAny();
  }
  ObjectReader reader(document, "", &findings);
  head.model = reader.Required("model", reader.Text("model"), "the name of a model that is served").value_or("");
  const auto method = ParseMethod(reader.Text("method").value_or("olng"));
  if (!method || *method == ReconstructionMethod::kGraph) findings.Malformed("/method", "must be \"olng\", \"olng_kernels\", \"rbf\", \"rbf_lle\", \"gaussian\" or \"markers\"");
  head.method = method.value_or(ReconstructionMethod::kOlng);
  head.placements = ReadPlacementList(&reader, &findings);
  reader.RefuseOthers();
  findings.ThrowIfAny();
  return head;
}

}  // namespace morphograph
