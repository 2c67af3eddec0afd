#pragma once

#include <atomic>

#include "api/clip_store.h"
#include "api/metrics.h"
#include "api/model_registry.h"
#include "api/reconstructor_cache.h"

namespace morphograph {

class TrainingService;

/// What the routes of one server work on. Outlives the router.
struct Service {
  ModelRegistry models;
  ClipStore clips;
  ReconstructorCache reconstructors;
  Metrics metrics;
  std::atomic<bool> ready{false};       // requests are accepted: the server runs and is not stopping
  TrainingService* training = nullptr;  // where models can be trained over HTTP
};

}  // namespace morphograph
