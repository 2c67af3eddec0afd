// GET /livez, /readyz, /metrics, /openapi.json
#include "api/content_hash.h"
#include "api/content_negotiation.h"
#include "api/openapi.h"
#include "api/problem.h"
#include "api/routes.h"

namespace morphograph {
namespace {

HttpResponse Plain(std::string body) {
  HttpResponse response;
  response.Set("Content-Type", "text/plain; charset=utf-8");
  response.Set("Cache-Control", "no-store");
  response.body = std::move(body);
  return response;
}

HttpResponse Ready(const Service& service) {
  if (!service.ready) throw ProblemError(Problem{503, "not ready: the server starts or stops", {}, 1, {}});
  return Plain("ready\n");
}

HttpResponse MetricsText(const Service& service) {
  HttpResponse response = Plain(service.metrics.PrometheusText());
  response.headers[0].second = "text/plain; version=0.0.4; charset=utf-8";
  return response;
}

HttpResponse OpenApi(const HttpRequest& request) {
  static const std::string tag = '"' + ContentHash(OpenApiJson()) + '"';
  HttpResponse response;
  response.Set("ETag", tag);
  if (MatchesEntityTag(request.Header("If-None-Match"), tag)) {
    response.status = 304;
    return response;
  }
  response.Set("Content-Type", "application/json");
  response.body = OpenApiJson();
  return response;
}

}  // namespace

std::vector<Route> SystemRoutes(Service* service) {
  return {
      {"GET", "/livez", [](const HttpRequest&) { return Plain("alive\n"); }, 0, true},
      {"GET", "/readyz", [=](const HttpRequest&) { return Ready(*service); }, 0, true},
      {"GET", "/metrics", [=](const HttpRequest&) { return MetricsText(*service); }, 0, true},
      {"GET", "/openapi.json", OpenApi, 0, true},
  };
}

}  // namespace morphograph
