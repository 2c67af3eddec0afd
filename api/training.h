#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/dataset_loader.h"
#include "graph/motion_graph.h"

namespace morphograph {

/// What `train` and `POST /v1/models` ask for.
struct TrainingRequest {
  std::vector<std::filesystem::path> data;  // files and folders
  std::optional<std::filesystem::path> manifest;
  std::string name;                   // empty: the manifest's, else the action
  std::optional<std::string> action;  // empty: the manifest's
  DatasetLimits limits;
  int jobs = 1;
  std::string command;  // kept in the model as its provenance
  std::function<void(const std::string& stage, double fraction)> progress;  // of the whole, [0, 1]
  const std::atomic<bool>* cancelled = nullptr;
};

struct TrainingOutcome {
  std::shared_ptr<const MotionGraph> graph;
  int clips = 0;   // read
  int made = 0;    // mirrored or bent copies added
  double read_s = 0;
  double learn_s = 0;
  std::vector<std::string> notes;  // of reading: files left out, repairs
};

/// Reads the clips, adds the copies that the manifest asks for, and learns a graph from them.
/// @throws DatasetError for bad or insufficient data; TrainingCancelled.
TrainingOutcome Train(const TrainingRequest& request);

/// Everything that training has to say, as JSON (`train --report`).
std::string TrainingReportJson(const TrainingOutcome& outcome);

/// Whether a model may have this name: letters, digits, '.', '_', '-', not starting with a mark, at most 64.
bool IsModelName(std::string_view name);

}  // namespace morphograph
