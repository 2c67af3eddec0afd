#pragma once

#include <memory>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <vector>

#include "graph/graph_summary.h"
#include "graph/motion_graph.h"

namespace morphograph {

/// A model under the name that it is served by. Immutable.
struct ServedModel {
  std::string name;
  std::shared_ptr<const MotionGraph> graph;
  GraphSummary summary;
};

/// The models of a server. Safe from any thread; a model in use outlives its removal.
class ModelRegistry {
 public:
  /// Serves a graph under `name`.
  /// @return false when the name is taken by a model of other content.
  bool Add(const std::string& name, std::shared_ptr<const MotionGraph> graph);

  /// By name, else by content hash; null when there is none.
  std::shared_ptr<const ServedModel> Find(std::string_view name_or_hash) const;

  /// In the order in which they were added.
  std::vector<std::shared_ptr<const ServedModel>> List() const;

 private:
  mutable std::shared_mutex mutex_;
  std::vector<std::shared_ptr<const ServedModel>> models_;
};

}  // namespace morphograph
