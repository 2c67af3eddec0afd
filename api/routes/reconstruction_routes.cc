// POST /v1/reconstructions
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "api/clip_response.h"
#include "api/content_negotiation.h"
#include "api/error_mapping.h"
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

constexpr std::size_t kLongestLine = 1 << 20;

// The lines of a body that may be coming still.
class Lines {
 public:
  explicit Lines(const HttpRequest& request) : text_(request.body), incoming_(request.incoming) {}

  /// The next line without its end; none at the end of the body. Waits for it. @throws ProblemError as HttpRequest::incoming, and 413 for a line without end.
  std::optional<std::string> Next() {
    while (true) {
      const std::size_t end = text_.find('\n', std::max(at_, seen_));
      seen_ = text_.size();
      if (end != std::string::npos) {
        std::string line = text_.substr(at_, end - at_);
        seen_ = at_ = end + 1;
        return line;
      }
      if (text_.size() - at_ > kLongestLine) throw ProblemError(413, "a line is too long");
      const std::string more = incoming_ ? incoming_() : std::string();
      if (more.empty()) break;
      text_.erase(0, at_);
      seen_ -= at_;
      at_ = 0;
      text_ += more;
    }
    if (at_ == text_.size()) return std::nullopt;
    std::string line = text_.substr(at_);
    at_ = text_.size();
    return line;
  }

 private:
  std::string text_;
  std::size_t at_ = 0, seen_ = 0;  // the next line begins; no line ends before
  std::function<std::string()> incoming_;
};

// The first line says what to reconstruct with; an answer line a frame follows as the lines with readings are worked off, which may come as the answer goes out.
HttpResponse StreamReconstruction(Service* service, const HttpRequest& request) {
  if (ChooseMediaType(request.Header("Accept"), {kStreamType, "application/jsonl"}) < 0) throw ProblemError(406, "streams are answered as application/x-ndjson");
  struct Answer {
    explicit Answer(Lines of_request) : lines(std::move(of_request)) {}
    internal::LimitedPlaces::Place place{&stream_places};
    Lines lines;
    std::unique_ptr<ReconstructionStream> stream;
    int line = 1;
    bool done = false;
  };
  const auto answer = std::make_shared<Answer>(Lines(request));
  const StreamHead head = ParseStreamHead(answer->lines.Next().value_or(""));
  const std::shared_ptr<const ServedModel> model = FindServed(service->models, head.model);
  answer->stream = std::make_unique<ReconstructionStream>(service->reconstructors.Get(model->graph, head.method, head.placements));

  HttpResponse response;
  response.Set("Content-Type", kStreamType);
  response.Set("Cache-Control", "no-store");
  response.Set("Morphograph-Model", model->graph->hash());
  response.more = [answer]() -> std::string {
    std::string lines;
    try {
      while (lines.empty() && !answer->done) {
        ++answer->line;
        const std::optional<std::string> line = answer->lines.Next();
        answer->done = !line;
        lines = line ? answer->stream->Push(*line) : answer->stream->Finish();
      }
    } catch (...) {
      // The answer is under way: the last line says why it ends.
      answer->done = true;
      lines = nlohmann::ordered_json({{"error", {{"line", answer->line}, {"detail", ProblemLine(ProblemFrom(std::current_exception()))}}}}).dump() + "\n";
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
  return {{"POST", "/v1/reconstructions", [=](const HttpRequest& request) { return CreateReconstruction(service, request); }, kMaxReadingsBytes, false, kStreamType}};
}

}  // namespace morphograph
