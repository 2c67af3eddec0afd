#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;

namespace morphograph {

enum class JobState { kQueued, kRunning, kSucceeded, kFailed, kCancelled };
std::string_view JobStateName(JobState state);

/// A training job as it is kept.
struct Job {
  std::string id;
  JobState state = JobState::kQueued;
  std::string stage;
  double progress = 0;  // of the whole, [0, 1]
  std::string detail;   // why it failed, or what training had to say
  std::string model;    // name of the model to be
  std::string action;
  int files = 0;
  std::string created;  // RFC 3339, UTC

  bool IsFinished() const { return state != JobState::kQueued && state != JobState::kRunning; }
};

/// Training jobs in an SQLite database, so that they outlive the process. Safe from any thread.
class JobStore {
 public:
  /// Opens or creates the database. Jobs that were running when the last process ended are queued again.
  /// @param url  a path, "sqlite:PATH", or "sqlite::memory:".
  /// @throws std::invalid_argument for another kind of URL; std::runtime_error naming the file and SQLite's reason.
  explicit JobStore(const std::string& url);
  ~JobStore();
  JobStore(const JobStore&) = delete;
  JobStore& operator=(const JobStore&) = delete;

  void Insert(const Job& job);
  std::optional<Job> Find(const std::string& id) const;
  /// Sets everything but id, model, files and time.
  void Update(const Job& job);
  /// The oldest that is queued.
  std::optional<Job> NextQueued() const;
  int Count(JobState state) const;
  /// Whether an unfinished job is to make a model of this name.
  bool IsModelAwaited(const std::string& model) const;
  /// Oldest first.
  std::vector<Job> List() const;
  /// Forgets all finished jobs but the `kept` latest.
  void Prune(int kept);

 private:
  class Statement;
  void Execute(const char* sql);

  std::string path_;
  mutable std::mutex mutex_;
  sqlite3* database_ = nullptr;
};

}  // namespace morphograph
