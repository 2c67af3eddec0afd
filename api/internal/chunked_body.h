#pragma once

#include <atomic>
#include <chrono>
#include <string>

#include "api/internal/socket_stream.h"

namespace morphograph::internal {

/// A body that is still being sent, in chunks (RFC 9112, 7.1), read more strictly than the RFC asks: sizes are one to six hexadecimal digits, without
/// extensions, and nothing comes behind the last chunk. Where this reader and another disagreed on the end, nothing could be smuggled: the connection
/// is closed behind such a request.
class ChunkedBody {
 public:
  /// @param patience  for which no line may end; @param stopping  ends the body once it is true. The socket and it must outlive the body.
  ChunkedBody(SocketStream* socket, std::chrono::seconds patience, const std::atomic<bool>* stopping)
      : socket_(socket), patience_(patience), stopping_(stopping) {}

  /// What came since, as soon as there is any; empty at the end of the body.
  /// @throws ProblemError: 400 for chunks that are not well formed or a body cut short, 408 when no line came for too long.
  std::string Next();

 private:
  void WaitFor(std::size_t bytes);
  void ReadSize();

  SocketStream* socket_;
  const std::chrono::seconds patience_;
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::now() + patience_;  // renewed with each line, not with each byte
  const std::atomic<bool>* stopping_;
  std::size_t left_ = 0;  // of the chunk
  bool first_ = true, ended_ = false;
};

}  // namespace morphograph::internal
