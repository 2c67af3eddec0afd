#pragma once

#include <chrono>
#include <string>

namespace morphograph {

/// Progress of long work on standard error: one line that is rewritten on a terminal, plain lines elsewhere (a line a stage,
/// and at most one every five seconds within it).
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  /// Ends the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// @param fraction  of the whole work, [0, 1].
  void Tell(const std::string& stage, double fraction);

 private:
  using Clock = std::chrono::steady_clock;
  const bool quiet_;
  const bool terminal_;
  std::string stage_;
  Clock::time_point told_{};
  bool open_ = false;
};

}  // namespace morphograph
