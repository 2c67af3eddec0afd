#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/dataset_loader.h"
#include "datasets/manifest.h"
#include "graph/motion_graph.h"

namespace morphograph {

/// What `train` and `POST /v1/models` ask for.
struct TrainingRequest {
  std::vector<std::filesystem::path> data;  // files and folders
  std::optional<std::filesystem::path> manifest;
  std::string name;                   // empty: the manifest's, else the action
  std::optional<std::string> action;  // empty: the manifest's
  std::optional<std::filesystem::path> keyframe_labels;  // outranks the file that the manifest's "keyframes" names
  DatasetLimits limits;
  bool keep_recordings = true;  // in the model, for reconstruction from sensors
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

/// A request that no data could serve; `pointer` as in a problem's errors ("/action").
class TrainingUsageError : public std::runtime_error {
 public:
  TrainingUsageError(std::string pointer, const std::string& detail) : std::runtime_error(detail), pointer_(std::move(pointer)) {}
  const std::string& pointer() const { return pointer_; }

 private:
  std::string pointer_;
};

/// What the model will be called and what it learns.
struct TrainingSubject {
  std::string name, action;
};

/// What can be told before any clip is read. @param has_labels  key frames come from labelled examples.
/// @throws TrainingUsageError when the name is none for a model, or the action has no key frames by feature and no labels.
TrainingSubject CheckTraining(const std::string& name, const std::optional<std::string>& action, const DatasetManifest& manifest,
                              bool has_labels);

/// Reads the clips, adds the copies that the manifest asks for, and learns a graph from them.
/// @throws TrainingUsageError before anything is read; DatasetError for bad or insufficient data; TrainingCancelled.
TrainingOutcome Train(const TrainingRequest& request);

/// Everything that training has to say, as JSON (`train --report`).
std::string TrainingReportJson(const TrainingOutcome& outcome);

/// Whether a model may have this name: letters, digits, '.', '_', '-', not starting with a mark, at most 64.
bool IsModelName(std::string_view name);

}  // namespace morphograph
