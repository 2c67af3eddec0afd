#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace morphograph {

/// Calls `body(i)` for i in [0, count) on up to `jobs` threads. Each call writes its own slot, so results do not depend on `jobs`.
/// The exception of the lowest index that threw is passed on; later work is then skipped.
template <typename Body>
void ParallelFor(int jobs, int count, const Body& body) {
  const int threads = std::clamp(jobs, 1, std::max(1, count));
  std::atomic<int> next = 0;
  std::mutex mutex;
  std::exception_ptr error;
  int error_index = count;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i < error_index) error = std::current_exception(), error_index = i;
        next = count;
      }
    }
  };
  std::vector<std::jthread> pool;
  for (int t = 1; t < threads; ++t) pool.emplace_back(work);
  work();
  pool.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace morphograph
