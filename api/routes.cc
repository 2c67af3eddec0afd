#include "api/routes.h"

namespace morphograph {

std::vector<Route> AllRoutes(Service* service) {
  std::vector<Route> all;
  for (auto& part : {ClipRoutes(service), VariantRoutes(service), EvaluationRoutes(service), ModelRoutes(service), JobRoutes(service),
                     ReconstructionRoutes(service), SystemRoutes(service), ViewerRoutes()})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace morphograph
