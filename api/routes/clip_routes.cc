// POST /v1/clips, GET /v1/clips/{id}, GET /v1/clips/{id}/report
#include <chrono>

#include "api/clip_request.h"
#include "api/clip_response.h"
#include "api/content_negotiation.h"
#include "api/glb_writer.h"
#include "api/problem.h"
#include "api/routes.h"
#include "api/routes/request_parts.h"
#include "synthesis/control/sensor_guide.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

enum class ClipForm { kBvh, kJson, kGlb, kReport };

constexpr std::string_view kBvhType = "text/plain; charset=utf-8";

ClipForm NegotiatedForm(const HttpRequest& request) {
  switch (ChooseMediaType(request.Header("Accept"), {"text/plain", "application/json", "model/gltf-binary"})) {
    case 0: return ClipForm::kBvh;
    case 1: return ClipForm::kJson;
    case 2: return ClipForm::kGlb;
    default:
      throw ProblemError(406, "a clip is given as text/plain (BVH), application/json or model/gltf-binary");
  }
}

std::string EntityTag(const std::string& id, ClipForm form) {
  static constexpr const char* kSuffix[] = {"bvh", "json", "glb", "report"};
  return '"' + id + '.' + kSuffix[static_cast<int>(form)] + '"';
}

void SetClipHeaders(const std::string& id, ClipForm form, const ClipStore::Entry& entry, HttpResponse* response) {
  response->Set("ETag", EntityTag(id, form));
  response->Set("Cache-Control", "private, no-cache");  // kept, but asked for again: a 304 costs nothing
  response->Set("Vary", "Accept");
  response->Set("Morphograph-Seed", std::to_string(*entry.request.seed));
  response->Set("Morphograph-Model", entry.model->graph->hash());
}

HttpResponse MakeClip(Service* service, const std::string& id, ClipForm form, const ClipStore::Entry& entry) {
  const auto started = std::chrono::steady_clock::now();
  SynthesisResult made = Synthesize(*entry.model->graph, ToSynthesisRequest(entry.request));
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started;
  made.report.model_name = entry.model->name;  // as it was asked for: two files may call their models the same
  service->metrics.CountClip(made.clip.frame_count(), elapsed.count());

  HttpResponse response;
  SetClipHeaders(id, form, entry, &response);
  const auto attach = [&](const std::string& extension) {
    response.Set("Content-Disposition",
                 "attachment; filename=\"" + ClipFileName(entry.model->name, *entry.request.seed, extension) + '"');
  };
  switch (form) {
    case ClipForm::kBvh:
      response.Set("Content-Type", std::string(kBvhType));
      attach(".bvh");
      response.body = ClipBvh(made.clip, entry.request.output);
      break;
    case ClipForm::kJson:
      response.Set("Content-Type", "application/json");
      response.body = ClipJson(ClipBvh(made.clip, entry.request.output), ReportJson(made.report));
      break;
    case ClipForm::kGlb:
      response.Set("Content-Type", "model/gltf-binary");
      attach(".glb");
      response.body = WriteGlb(made.clip);
      break;
    case ClipForm::kReport:
      response.Set("Content-Type", "application/json");
      response.body = ReportJson(made.report);
      break;
  }
  return response;
}

HttpResponse CreateClip(Service* service, const HttpRequest& request) {
  const std::string& text = ClipRequestText(request);
  const ClipForm form = NegotiatedForm(request);
  ClipStore::Entry entry{ParseClipRequest(text), nullptr};
  entry.model = FindServed(service->models, entry.request.model);
  if (!entry.request.seed) entry.request.seed = DrawSeed();
  const std::string id = ClipId(entry.model->graph->hash(), entry.request);
  if (auto& sensors = entry.request.control.sensors) {
    // Kept with the request, for whoever asks for the clip or its report again.
    sensors->guide = MakeSensorGuide(*entry.model->graph, ToSynthesisRequest(entry.request), SensorStepsOf(service, *entry.model));
  }
  HttpResponse response = MakeClip(service, id, form, entry);
  response.Set("Location", "/v1/clips/" + id);
  service->clips.Put(id, std::move(entry));
  return response;
}

HttpResponse GetClip(Service* service, const HttpRequest& request, bool report) {
  const std::string& id = request.arguments[0];
  const auto entry = service->clips.Get(id);
  if (!entry) throw ProblemError(404, "no clip of that id was made lately");
  ClipForm form = ClipForm::kReport;
  if (!report) {
    form = NegotiatedForm(request);
  } else if (ChooseMediaType(request.Header("Accept"), {"application/json"}) < 0) {
    throw ProblemError(406, "a report is application/json");
  }
  if (MatchesEntityTag(request.Header("If-None-Match"), EntityTag(id, form))) {
    HttpResponse unchanged;
    unchanged.status = 304;
    SetClipHeaders(id, form, *entry, &unchanged);
    return unchanged;
  }
  return MakeClip(service, id, form, *entry);
}

}  // namespace

std::vector<Route> ClipRoutes(Service* service) {
  return {
      {"POST", "/v1/clips", [=](const HttpRequest& request) { return CreateClip(service, request); },
       kMaxClipRequestBytes},
      {"GET", "/v1/clips/{id}", [=](const HttpRequest& request) { return GetClip(service, request, false); }},
      {"GET", "/v1/clips/{id}/report", [=](const HttpRequest& request) { return GetClip(service, request, true); }},
  };
}

}  // namespace morphograph
