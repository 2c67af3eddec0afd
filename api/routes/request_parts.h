#pragma once

#include <memory>
#include <string>

#include "api/http_message.h"
#include "api/model_registry.h"
#include "api/service.h"
#include "synthesis/control/sensor_guide.h"

namespace morphograph {

/// The body of a request that takes a clip request. @throws ProblemError 415 when it says to be something else than JSON.
const std::string& ClipRequestText(const HttpRequest& request);

/// A model that is served. @throws ProblemError 404 at /model, naming those that are.
std::shared_ptr<const ServedModel> FindServed(const ModelRegistry& models, const std::string& name);

/// For MakeSensorGuide(): with what was made for the same sensors before. Both must outlive it.
SensorStepsSource SensorStepsOf(Service* service, const ServedModel& model);

}  // namespace morphograph
