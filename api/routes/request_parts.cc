#include "api/routes/request_parts.h"

#include "api/content_negotiation.h"
#include "api/problem.h"

namespace morphograph {

const std::string& ClipRequestText(const HttpRequest& request) {
  const std::string_view type = MediaTypeOf(request.Header("Content-Type"));
  if (!type.empty() && !EqualsIgnoringCase(type, "application/json"))
    throw ProblemError(415, "the request is read as application/json, not " + Excerpt(type));
  return request.body;
}

std::shared_ptr<const ServedModel> FindServed(const ModelRegistry& models, const std::string& name) {
  if (auto model = models.Find(name)) return model;
  std::string names;
  for (const auto& model : models.List()) names += (names.empty() ? "" : ", ") + model->name;
  Problem problem{404, "no model of that name is served", {}, {}, {}};
  problem.errors = {{"/model", names.empty() ? "no model is served" : "served are: " + Excerpt(names, 400)}};
  throw ProblemError(std::move(problem));
}

SensorStepsSource SensorStepsOf(Service* service, const ServedModel& model) {
  return [service, &model](const std::vector<Placement>& sensors) { return service->reconstructors.Get(model.graph, ReconstructionMethod::kGraph, sensors)->steps(); };
}

}  // namespace morphograph
