#pragma once

#include <algorithm>
#include <mutex>
#include <string>

#include "graph/graph_builder.h"

namespace morphograph {

/// Tells the caller of training how far it is, and lets it stop.
class TrainingProgress {
 public:
  explicit TrainingProgress(const TrainingOptions& options) : options_(options) {}
  /// The next stage, [from, to] of the whole, in `work` steps.
  void Begin(const std::string& stage, double from, double to, int work) {
    const std::lock_guard lock(mutex_);
    stage_ = stage, from_ = from, to_ = to, work_ = std::max(1, work), done_ = 0;
    Tell();
  }
  /// One of them is done. @throws TrainingCancelled.
  void Step() {
    if (options_.cancelled && options_.cancelled->load()) throw TrainingCancelled();
    const std::lock_guard lock(mutex_);
    ++done_;
    Tell();
  }

 private:
  void Tell() const {
    if (options_.progress) options_.progress(stage_, from_ + (to_ - from_) * done_ / work_);
  }
  const TrainingOptions& options_;
  std::mutex mutex_;
  std::string stage_;
  double from_ = 0, to_ = 0;
  int work_ = 1, done_ = 0;
};

}  // namespace morphograph
