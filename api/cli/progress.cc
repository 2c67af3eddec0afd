#include "api/cli/progress.h"

#include <unistd.h>

#include <cstdio>

namespace morphograph {

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (open_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::Tell(const std::string& stage, double fraction) {
  if (quiet_) return;
  const auto now = Clock::now();
  const auto rest = terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(5000);
  if (stage == stage_ && now - told_ < rest) return;
  stage_ = stage;
  told_ = now;
  const int percent = static_cast<int>(100 * fraction);
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K%3d %% %s", percent, stage.c_str());
    open_ = true;
  } else {
    std::fprintf(stderr, "%3d %% %s\n", percent, stage.c_str());
  }
  std::fflush(stderr);
}

}  // namespace morphograph
