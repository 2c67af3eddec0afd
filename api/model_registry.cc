#include "api/model_registry.h"

#include <mutex>

namespace morphograph {

bool ModelRegistry::Add(const std::string& name, std::shared_ptr<const MotionGraph> graph) {
  auto model = std::make_shared<ServedModel>();
  model->name = name;
  model->summary = Summarise(*graph);
  model->graph = std::move(graph);
  const std::unique_lock lock(mutex_);
  for (const auto& known : models_)
    if (known->name == name) return known->graph->hash() == model->graph->hash();
  models_.push_back(std::move(model));
  return true;
}

std::shared_ptr<const ServedModel> ModelRegistry::Find(std::string_view name_or_hash) const {
  const std::shared_lock lock(mutex_);
  for (const auto& model : models_)
    if (model->name == name_or_hash) return model;
  for (const auto& model : models_)
    if (model->graph->hash() == name_or_hash) return model;
  return nullptr;
}

std::vector<std::shared_ptr<const ServedModel>> ModelRegistry::List() const {
  const std::shared_lock lock(mutex_);
  return models_;
}

}  // namespace morphograph
