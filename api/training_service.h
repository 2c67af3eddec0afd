#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "api/job_store.h"
#include "api/service.h"

namespace morphograph {

/// What a client uploads to train from.
struct TrainingUpload {
  std::vector<std::pair<std::string, std::string_view>> clips;  // name as sent, BVH text
  std::string_view manifest;                                    // JSON, may be empty
  std::string_view keyframes;                                   // labelled frames, JSON (keyframe_labels.h), may be empty
  std::string name;                                             // of the model; empty: made from the job's id
  std::string action;                                           // empty: the manifest's
};

/// Trains models in the background, one at a time, and serves them.
///
/// Layout of the data folder: `models/NAME.mgm`, `uploads/JOB/` (until the job ends), and the job database unless it is elsewhere.
/// Jobs that wait or run when the process ends are done by the next one.
class TrainingService {
 public:
  /// Opens the folder (made when absent), serves the models that it holds, and starts to work.
  /// @throws std::runtime_error when the folder or the database cannot be used.
  TrainingService(Service* service, std::filesystem::path folder, const std::string& database_url, int threads);
  /// Interrupts the job under way; it stays queued.
  ~TrainingService();

  /// Keeps the upload and queues it. @throws ProblemError: 400 for a bad name or no clips, 409 for a name that is
  ///   taken, 429 when too many jobs wait or their uploads fill the folder; DatasetError and TrainingUsageError for a manifest, labels or
  ///   an action that cannot be used.
  Job Submit(const TrainingUpload& upload);
  /// @throws ProblemError 404.
  Job Get(const std::string& id) const;
  /// @throws ProblemError: 404, or 409 when it has finished.
  Job Cancel(const std::string& id);

 private:
  void LoadModels();
  void RemoveLeftOvers();  // uploads whose job has ended
  void Work();
  void Run(Job job);
  void CountJobs();

  Service* service_;
  std::filesystem::path folder_;
  JobStore store_;
  int threads_;
  mutable std::mutex mutex_;  // of what follows; the store has its own
  std::condition_variable wake_;
  bool stopping_ = false;
  bool changed_ = true;  // a job was queued
  std::string running_;  // id, empty when idle
  std::set<std::string> arriving_;  // names of models whose uploads are being written
  std::atomic<bool> cancelled_{false};
  std::thread worker_;
};

}  // namespace morphograph
