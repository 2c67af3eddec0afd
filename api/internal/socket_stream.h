#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace morphograph::internal {

/// A connected TCP socket whose every read and write ends by a deadline, however slowly the other side drips.
///
/// By poll(), so that descriptors above select()'s 1024 work. Does not own the descriptor.
class SocketStream {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  explicit SocketStream(int socket) : socket_(socket) {}

  /// Reads some bytes behind those in buffered(), at most `limit`. False when the other side closed, the time is over
  /// or the socket failed.
  bool Fill(TimePoint deadline, std::size_t limit);

  /// Up to `size` bytes, buffered ones first; 0 when the other side closed, the time is over or the socket failed.
  std::size_t Read(char* to, std::size_t size, TimePoint deadline);

  /// Writes both, one behind the other. False when that failed or the time is over.
  bool Write(std::string_view first, std::string_view second, TimePoint deadline);

  /// Half-closes, then reads and drops what still comes for a while: closing with unread input would reset the
  /// connection and could take the answer away from the client before it has read it.
  void Linger(TimePoint deadline);

  /// Whether the other side has closed, or broken, its direction, and nothing of it is left to read. Never waits; from any thread.
  bool IsClosedByPeer() const;

  std::string_view buffered() const { return std::string_view(buffer_).substr(at_); }
  void Consume(std::size_t bytes) { at_ += bytes; }

 private:
  bool Wait(short events, TimePoint deadline) const;

  int socket_;
  std::string buffer_;
  std::size_t at_ = 0;
};

}  // namespace morphograph::internal
