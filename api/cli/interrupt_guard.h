#pragma once

#include <csignal>
#include <functional>
#include <thread>

namespace morphograph {

/// While it lives, SIGINT, SIGTERM and SIGHUP do not end the process at once: `clean_up` runs first, on a thread of its own,
/// and then the signal ends the process as it would have. Signals that the process was told to ignore stay ignored.
///
/// Holds for threads started after it; those started before must have ended, or they would take the signal. After
/// `clean_up` nothing else of the process matters: it may keep its locks.
class InterruptGuard {
 public:
  /// @throws std::system_error when the system refuses the descriptors.
  explicit InterruptGuard(std::function<void()> clean_up);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void Watch();

  std::function<void()> clean_up_;
  sigset_t outside_;      // the mask to go back to
  int signals_ = -1;      // signalfd
  int end_ = -1;          // eventfd, told by the destructor
  std::thread watcher_;
};

}  // namespace morphograph
