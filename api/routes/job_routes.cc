// POST /v1/models, GET and DELETE /v1/jobs/{id}
#include <nlohmann/json.hpp>

#include "api/json_guard.h"
#include "api/multipart.h"
#include "api/problem.h"
#include "api/request/object_reader.h"
#include "api/routes.h"
#include "api/training_service.h"

namespace morphograph {
namespace {

TrainingService& TrainingOf(Service* service) {
  if (!service->training) throw ProblemError(404, "this server does not train models");
  return *service->training;
}

HttpResponse JobResponse(int status, const Job& job) {
  HttpResponse response;
  response.status = status;
  response.Set("Content-Type", "application/json");
  response.Set("Cache-Control", "no-store");
  response.body = nlohmann::ordered_json{{"id", job.id},
                                         {"state", JobStateName(job.state)},
                                         {"stage", job.stage},
                                         {"progress", job.progress},
                                         {"detail", job.detail},
                                         {"model", job.model},
                                         {"action", job.action},
                                         {"files", job.files},
                                         {"created", job.created}}
                      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return response;
}

void ReadSettings(std::string_view text, TrainingUpload* upload) {
  const nlohmann::json settings = ParseUntrustedJson(text);
  Findings findings("the part 'settings'");
  if (!settings.is_object()) {
    findings.Malformed("", "must be an object");
    findings.ThrowIfAny();
  }
  ObjectReader reader(settings, "", &findings);
  upload->name = reader.Text("name").value_or(upload->name);
  upload->action = reader.Text("action").value_or(upload->action);
  reader.RefuseOthers();
  findings.ThrowIfAny();
}

HttpResponse SubmitTraining(Service* service, const HttpRequest& request) {
  TrainingService& training = TrainingOf(service);
  TrainingUpload upload;
  for (const MultipartPart& part : ParseMultipart(request.Header("Content-Type"), request.body)) {
    if (part.name == "settings") {
      ReadSettings(part.content, &upload);
    } else if (part.name == "manifest") {
      upload.manifest = part.content;
    } else if (part.name == "keyframes") {
      upload.keyframes = part.content;
    } else if (part.name == "name") {
      upload.name = std::string(part.content);
    } else if (part.name == "action") {
      upload.action = std::string(part.content);
    } else if (!part.file_name.empty()) {
      upload.clips.emplace_back(part.file_name, part.content);
    } else {
      throw ProblemError(400, "unknown part '" + Excerpt(part.name) +
                                  "': clips are parts with a file name; others are settings, manifest, keyframes, name, action");
    }
  }
  const Job job = training.Submit(upload);
  HttpResponse response = JobResponse(202, job);
  response.Set("Location", "/v1/jobs/" + job.id);
  return response;
}

}  // namespace

std::vector<Route> JobRoutes(Service* service) {
  return {
      {"POST", "/v1/models", [=](const HttpRequest& request) { return SubmitTraining(service, request); },
       kMaxTrainingBytes},
      {"GET", "/v1/jobs/{id}",
       [=](const HttpRequest& request) { return JobResponse(200, TrainingOf(service).Get(request.arguments[0])); }},
      {"DELETE", "/v1/jobs/{id}",
       [=](const HttpRequest& request) { return JobResponse(200, TrainingOf(service).Cancel(request.arguments[0])); }},
  };
}

}  // namespace morphograph
