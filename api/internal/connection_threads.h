#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace morphograph::internal {

/// Threads that each look after one connection at a time; started when needed, reused, bounded in number.
class ConnectionThreads {
 public:
  explicit ConnectionThreads(std::size_t max_threads) : max_threads_(max_threads) {}
  ~ConnectionThreads() { Join(); }
  ConnectionThreads(const ConnectionThreads&) = delete;
  ConnectionThreads& operator=(const ConnectionThreads&) = delete;

  /// False, and `work` is not taken, when all threads are busy or no further one can be started.
  bool TryStart(const std::function<void()>& work) {
    const std::lock_guard lock(mutex_);
    if (work_.size() >= idle_ && threads_.size() >= max_threads_) return false;
    work_.push_back(work);
    if (work_.size() <= idle_) {
      wake_.notify_one();
      return true;
    }
    try {
      threads_.emplace_back([this] { Loop(); });
    } catch (const std::system_error&) {
      work_.pop_back();
      return false;
    }
    return true;
  }

  /// Waits for all work to end.
  void Join() {
    std::vector<std::thread> threads;
    {
      const std::lock_guard lock(mutex_);
      joining_ = true;
      threads.swap(threads_);
    }
    wake_.notify_all();
    for (std::thread& thread : threads) thread.join();
  }

 private:
  void Loop() {
    std::unique_lock lock(mutex_);
    while (true) {
      while (work_.empty()) {
        if (joining_) return;
        ++idle_;
        wake_.wait(lock);
        --idle_;
      }
      const std::function<void()> work = std::move(work_.front());
      work_.pop_front();
      lock.unlock();
      work();
      lock.lock();
    }
  }

  const std::size_t max_threads_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> work_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;  // waiting; those just woken count until they run, as does the work meant for them
  bool joining_ = false;
};

}  // namespace morphograph::internal
