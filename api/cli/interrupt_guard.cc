#include "api/cli/interrupt_guard.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace morphograph {
namespace {

// A blocked signal waits even where it is ignored, so the ignored ones (nohup) are left alone.
sigset_t SignalsThatEnd() {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (::sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_DFL) ::sigaddset(&set, signal);
  }
  return set;
}

// As if nobody had held the signal back: the shell that waits for this process sees which one it was.
void DieOf(int signal) {
  sigset_t only;
  ::sigemptyset(&only);
  ::sigaddset(&only, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
  ::raise(signal);
}

}  // namespace

InterruptGuard::InterruptGuard(std::function<void()> clean_up) : clean_up_(std::move(clean_up)) {
  const sigset_t signals = SignalsThatEnd();
  signals_ = ::signalfd(-1, &signals, SFD_CLOEXEC);
  end_ = ::eventfd(0, EFD_CLOEXEC);
  if (signals_ < 0 || end_ < 0) {
    const std::error_code error(errno, std::generic_category());
    if (signals_ >= 0) ::close(signals_);
    throw std::system_error(error, "cannot watch for signals");
  }
  ::pthread_sigmask(SIG_BLOCK, &signals, &outside_);
  watcher_ = std::thread([this] { Watch(); });
}

InterruptGuard::~InterruptGuard() {
  const std::uint64_t one = 1;
  while (::write(end_, &one, sizeof one) < 0 && errno == EINTR) continue;
  watcher_.join();
  ::close(end_);
  ::close(signals_);
  // What came in the last moment, after the watcher had gone, strikes here.
  ::pthread_sigmask(SIG_SETMASK, &outside_, nullptr);
}

void InterruptGuard::Watch() {
  pollfd waiting[] = {{signals_, POLLIN, 0}, {end_, POLLIN, 0}};
  while (::poll(waiting, 2, -1) < 0 && errno == EINTR) continue;
  signalfd_siginfo caught;
  if (!(waiting[0].revents & POLLIN) || ::read(signals_, &caught, sizeof caught) != sizeof caught) return;
  clean_up_();
  DieOf(static_cast<int>(caught.ssi_signo));
}

}  // namespace morphograph
