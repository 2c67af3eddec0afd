// POST /v1/evaluations
#include "api/content_negotiation.h"
#include "api/evaluation_response.h"
#include "api/problem.h"
#include "api/routes.h"

namespace morphograph {
namespace {

HttpResponse Evaluate(const HttpRequest& request) {
  // BVH has no registered type, and some clients label every body as a form: refuse only what is plainly something else.
  const std::string_view type = MediaTypeOf(request.Header("Content-Type"));
  for (const std::string_view other :
       {"application/json", "application/xml", "text/html", "text/xml", "text/csv", "multipart/form-data"}) {
    if (EqualsIgnoringCase(type, other)) throw ProblemError(415, "an evaluation takes BVH as text/plain, not " + Excerpt(type));
  }
  if (type.starts_with("image/") || type.starts_with("audio/") || type.starts_with("video/"))
    throw ProblemError(415, "an evaluation takes BVH as text/plain, not " + Excerpt(type));
  if (ChooseMediaType(request.Header("Accept"), {"application/json"}) < 0)
    throw ProblemError(406, "an evaluation is application/json");
  if (request.body.empty()) throw ProblemError(400, "the body is empty; send a BVH");
  HttpResponse response;
  response.Set("Content-Type", "application/json");
  response.Set("Cache-Control", "no-store");
  response.body = EvaluateBvh(request.body, "body").dump();
  return response;
}

}  // namespace

std::vector<Route> EvaluationRoutes(Service*) {
  return {{"POST", "/v1/evaluations", Evaluate, kMaxEvaluationBytes}};
}

}  // namespace morphograph
