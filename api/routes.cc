#include "api/routes.h"

namespace morphograph {

std::vector<Route> PlannedRoutes() {
  std::vector<Route> routes;
  for (const char* pattern : {"/v1/reconstructions"}) {
    Route route{"POST", pattern, nullptr};
    route.planned = true;
    routes.push_back(std::move(route));
  }
  return routes;
}

std::vector<Route> AllRoutes(Service* service) {
  std::vector<Route> all;
  for (auto& part : {ClipRoutes(service), VariantRoutes(service), EvaluationRoutes(service), ModelRoutes(service), JobRoutes(service),
                     SystemRoutes(service), ViewerRoutes(), PlannedRoutes()})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace morphograph
