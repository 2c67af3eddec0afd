// POST /v1/reconstructions
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "api/clip_response.h"
#include "api/content_negotiation.h"
#include "api/glb_writer.h"
#include "api/internal/limited_places.h"
#include "api/problem.h"
#include "api/reconstruction_report.h"
#include "api/reconstruction_request.h"
#include "api/reconstruction_stream.h"
#include "api/routes.h"
#include "api/routes/request_parts.h"
#include "datasets/errors.h"
#include "datasets/resample.h"

namespace morphograph {
namespace {

ReconstructedReadings Reconstruct(Service* service, const ServedModel& model, const ReconstructionRequest& request) {
  try {
    return ReconstructReadings(*model.graph, request, [&](const std::vector<Placement>& sensors) {
      return service->reconstructors.Get(model.graph, request.method, sensors);
    });
  } catch (const DatasetError& unfit) {
    // Well formed, but nothing can be made of them.
    throw ProblemError(Problem{422, "the request cannot be met", {{"/sensors/readings", unfit.what()}}, {}, {}});
  }
}

constexpr const char* kStreamType = "application/x-ndjson";
// Streams are worked off line by line while their answer goes out, beside the workers of other requests.
internal::LimitedPlaces stream_places(4, "other streams are being reconstructed; try again");

std::string_view TakeLine(std::string_view* text) {
  const std::size_t end = std::min(text->find('\n'), text->size());
  const std::string_view line = text->substr(0, end);
  text->remove_prefix(std::min(end + 1, text->size()));
  return line;
}

// The first line says what to reconstruct with; an answer line a frame follows as the lines with readings are worked off.
HttpResponse StreamReconstruction(Service* service, const HttpRequest& request) {
  if (ChooseMediaType(request.Header("Accept"), {kStreamType, "application/jsonl"}) < 0) throw ProblemError(406, "streams are answered as application/x-ndjson");
  struct Answer {
    internal::LimitedPlaces::Place place{&stream_places};
    std::string body;
    std::string_view rest;
    std::unique_ptr<ReconstructionStream> stream;
    int line = 1;
    bool done = false;
  };
  const auto answer = std::make_shared<Answer>();
  answer->body = request.body;
  answer->rest = answer->body;
  const StreamHead head = ParseStreamHead(TakeLine(&answer->rest));
  const std::shared_ptr<const ServedModel> model = FindServed(service->models, head.model);
  answer->stream = std::make_unique<ReconstructionStream>(service->reconstructors.Get(model->graph, head.method, head.placements));

  HttpResponse response;
  response.Set("Content-Type", kStreamType);
  response.Set("Cache-Control", "no-store");
  response.Set("Morphograph-Model", model->graph->hash());
  response.more = [answer]() -> std::string {
    std::string lines;
    try {
      while (lines.empty() && !answer->rest.empty()) {
        ++answer->line;
        lines = answer->stream->Push(TakeLine(&answer->rest));
      }
      if (lines.empty() && !answer->done) {
        answer->done = true;
        lines = answer->stream->Finish();
      }
    } catch (const ProblemError& error) {
      // The answer is under way: the last line says why it ends.
      answer->rest = {};
      answer->done = true;
      lines = nlohmann::ordered_json({{"error", {{"line", answer->line}, {"detail", ProblemLine(error.problem())}}}}).dump() + "\n";
    }
    return lines;
  };
  return response;
}

HttpResponse CreateReconstruction(Service* service, const HttpRequest& request) {
  if (EqualsIgnoringCase(MediaTypeOf(request.Header("Content-Type")), kStreamType)) return StreamReconstruction(service, request);
  const int form = ChooseMediaType(request.Header("Accept"), {"text/plain", "application/json", "model/gltf-binary"});
  if (form < 0) throw ProblemError(406, "a clip is given as text/plain (BVH), application/json or model/gltf-binary");
  const ReconstructionBody body = ParseReconstructionBody(ClipRequestText(request));
  const std::shared_ptr<const ServedModel> model = FindServed(service->models, body.model);
  const auto started = std::chrono::steady_clock::now();
  ReconstructedReadings made = Reconstruct(service, *model, body.request);
  made.reconstruction.report.model_name = model->name;
  MotionClip clip = body.output.frame_rate_hz ? Resample(made.reconstruction.clip, *body.output.frame_rate_hz) : made.reconstruction.clip;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started;
  service->metrics.CountClip(clip.frame_count(), elapsed.count());

  HttpResponse response;
  response.Set("Cache-Control", "no-store");
  response.Set("Morphograph-Model", model->graph->hash());
  const std::string name = model->name + "-" + std::string(MethodName(body.request.method));
  if (form == 1) {
    response.Set("Content-Type", "application/json");
    response.body = ClipJson(ClipBvh(clip, body.output), ReconstructionReportJson(body.request.method, made));
  } else if (form == 2) {
    response.Set("Content-Type", "model/gltf-binary");
    response.Set("Content-Disposition", "attachment; filename=\"" + name + ".glb\"");
    response.body = WriteGlb(clip);
  } else {
    response.Set("Content-Type", "text/plain; charset=utf-8");
    response.Set("Content-Disposition", "attachment; filename=\"" + name + ".bvh\"");
    response.body = ClipBvh(clip, body.output);
  }
  return response;
}

}  // namespace

std::vector<Route> ReconstructionRoutes(Service* service) {
  return {{"POST", "/v1/reconstructions", [=](const HttpRequest& request) { return CreateReconstruction(service, request); }, kMaxReadingsBytes}};
}

}  // namespace morphograph
