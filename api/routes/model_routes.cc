// GET /v1/models, /v1/models/{name}, /v1/models/{name}/graph
#include "api/content_hash.h"
#include "api/content_negotiation.h"
#include "api/model_description.h"
#include "api/problem.h"
#include "api/routes.h"

namespace morphograph {
namespace {

std::shared_ptr<const ServedModel> Wanted(const Service& service, const HttpRequest& request) {
  auto model = service.models.Find(request.arguments[0]);
  if (!model) throw ProblemError(404, "no model named " + Excerpt(request.arguments[0]) + " is served");
  return model;
}

// A name in a model that is no UTF-8 must not hide all others.
std::string Dumped(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

// Answers with a text, or with 304 when the client has it already.
HttpResponse Tagged(const HttpRequest& request, std::string type, std::string body) {
  HttpResponse response;
  const std::string tag = '"' + ContentHash(body) + '"';
  response.Set("ETag", tag);
  response.Set("Cache-Control", "private, no-cache");
  response.Set("Vary", "Accept");
  if (MatchesEntityTag(request.Header("If-None-Match"), tag)) {
    response.status = 304;
    return response;
  }
  response.Set("Content-Type", std::move(type));
  response.body = std::move(body);
  return response;
}

void NeedJson(const HttpRequest& request) {
  if (ChooseMediaType(request.Header("Accept"), {"application/json"}) < 0)
    throw ProblemError(406, "this is given as application/json");
}

HttpResponse ListModels(const Service& service, const HttpRequest& request) {
  NeedJson(request);
  nlohmann::ordered_json json = {{"models", nlohmann::ordered_json::array()}};
  for (const auto& model : service.models.List()) json["models"].push_back(ModelJson(model->summary, model->name));
  return Tagged(request, "application/json", Dumped(json));
}

HttpResponse GetModel(const Service& service, const HttpRequest& request) {
  NeedJson(request);
  const auto model = Wanted(service, request);
  return Tagged(request, "application/json", Dumped(ModelJson(model->summary, model->name)));
}

HttpResponse GetGraph(const Service& service, const HttpRequest& request) {
  const auto model = Wanted(service, request);
  switch (ChooseMediaType(request.Header("Accept"), {"application/json", "text/vnd.graphviz"})) {
    case 0: return Tagged(request, "application/json", Dumped(GraphJson(model->summary, model->name)));
    case 1: return Tagged(request, "text/vnd.graphviz; charset=utf-8", GraphDot(model->summary));
    default: throw ProblemError(406, "a graph is given as application/json or text/vnd.graphviz");
  }
}

}  // namespace

std::vector<Route> ModelRoutes(Service* service) {
  return {
      {"GET", "/v1/models", [=](const HttpRequest& request) { return ListModels(*service, request); }, 0, true},
      {"GET", "/v1/models/{name}", [=](const HttpRequest& request) { return GetModel(*service, request); }, 0, true},
      {"GET", "/v1/models/{name}/graph", [=](const HttpRequest& request) { return GetGraph(*service, request); }},
  };
}

}  // namespace morphograph
