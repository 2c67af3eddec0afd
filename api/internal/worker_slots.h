#pragma once

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>

#include "api/metrics.h"

namespace morphograph::internal {

/// Lets a fixed number of requests be carried out at a time; a bounded number waits, first come, first served.
class WorkerSlots {
 public:
  enum class Entry { kEntered, kFull, kLate };

  /// @param metrics  told how many requests are inside or waiting; must outlive this.
  WorkerSlots(int slots, int max_waiting, Metrics* metrics)
      : free_(slots), max_inside_(slots + max_waiting), metrics_(metrics) {}

  /// Waits for a slot, until `deadline` at most. After kEntered, and only then, Leave() is due.
  Entry Enter(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    if (inside_ >= max_inside_) return Entry::kFull;
    metrics_->queued = ++inside_;
    if (free_ > 0) {  // then nobody waits: Leave() hands a slot on before it frees it
      --free_;
      return Entry::kEntered;
    }
    const auto self = waiting_.emplace(waiting_.end());
    self->wake.wait_until(lock, deadline, [&] { return self->has_slot; });
    if (self->has_slot) {
      granted_.erase(self);
      return Entry::kEntered;
    }
    waiting_.erase(self);
    metrics_->queued = --inside_;
    return Entry::kLate;
  }

  /// Lets those that wait go first: gives the caller's slot to the longest waiting and waits for another one. Nobody waits: nothing
  /// happens. Between Enter() and Leave() only.
  void Yield() {
    std::unique_lock lock(mutex_);
    if (waiting_.empty()) return;
    HandOn();
    const auto self = waiting_.emplace(waiting_.end());
    self->wake.wait(lock, [&] { return self->has_slot; });
    granted_.erase(self);
  }

  /// A slot for a helper of a request that is inside already. False when none was free until `deadline`.
  bool EnterAsHelper(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    if (free_ > 0) {
      --free_;
      return true;
    }
    const auto self = waiting_.emplace(waiting_.end());
    self->wake.wait_until(lock, deadline, [&] { return self->has_slot; });
    if (!self->has_slot) {
      waiting_.erase(self);
      return false;
    }
    granted_.erase(self);
    return true;
  }
  void LeaveAsHelper() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) {
      ++free_;
    } else {
      HandOn();
    }
  }

  void Leave() {
    const std::lock_guard lock(mutex_);
    metrics_->queued = --inside_;
    if (waiting_.empty()) {
      ++free_;
    } else {
      HandOn();
    }
  }

 private:
  // The caller's slot to the one that waits for longest; there must be one.
  void HandOn() {
    granted_.splice(granted_.end(), waiting_, waiting_.begin());
    granted_.back().has_slot = true;
    granted_.back().wake.notify_one();
  }

  struct Waiter {
    std::condition_variable wake;
    bool has_slot = false;
  };

  std::mutex mutex_;
  int free_;
  int inside_ = 0;
  const int max_inside_;
  std::list<Waiter> waiting_, granted_;
  Metrics* metrics_;
};

}  // namespace morphograph::internal
