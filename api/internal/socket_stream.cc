#include "api/internal/socket_stream.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace morphograph::internal {
namespace {

constexpr std::size_t kBlock = 64 * 1024;

bool IsTemporary(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

}  // namespace

bool SocketStream::Wait(short events, TimePoint deadline) const {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd waiting{socket_, events, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(std::min<long long>(left.count(), 1'000'000)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

bool SocketStream::Fill(TimePoint deadline, std::size_t limit) {
  // Checked here too, since bytes that are always ready never come to the wait below.
  if (std::chrono::steady_clock::now() >= deadline) return false;
  if (at_ > 0) {
    buffer_.erase(0, at_);
    at_ = 0;
  }
  const std::size_t before = buffer_.size();
  buffer_.resize(before + std::min(limit, kBlock));
  const std::size_t got = [&]() -> std::size_t {
    while (true) {
      const ssize_t received = ::recv(socket_, buffer_.data() + before, buffer_.size() - before, MSG_DONTWAIT);
      if (received >= 0) return static_cast<std::size_t>(received);
      if (!IsTemporary(errno) || !Wait(POLLIN, deadline)) return 0;
    }
  }();
  buffer_.resize(before + got);
  return got > 0;
}

bool SocketStream::IsClosedByPeer() const {
  char byte;
  const ssize_t got = ::recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  return got == 0 || (got < 0 && !IsTemporary(errno));
}

std::size_t SocketStream::Read(char* to, std::size_t size, TimePoint deadline) {
  if (size == 0) return 0;
  if (buffered().empty() && !Fill(deadline, kBlock)) return 0;
  const std::size_t taken = std::min(size, buffered().size());
  std::memcpy(to, buffered().data(), taken);
  Consume(taken);
  return taken;
}

bool SocketStream::Write(std::string_view first, std::string_view second, TimePoint deadline) {
  while (!first.empty() || !second.empty()) {
    // sendmsg does not write to what it sends.
    std::array<iovec, 2> parts = {iovec{const_cast<char*>(first.data()), first.size()},
                                  iovec{const_cast<char*>(second.data()), second.size()}};
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    const ssize_t sent = ::sendmsg(socket_, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) {
      if (!IsTemporary(errno) || !Wait(POLLOUT, deadline)) return false;
      continue;
    }
    if (std::chrono::steady_clock::now() >= deadline) return false;
    const std::size_t of_first = std::min(first.size(), static_cast<std::size_t>(sent));
    first.remove_prefix(of_first);
    second.remove_prefix(static_cast<std::size_t>(sent) - of_first);
  }
  return true;
}

void SocketStream::Linger(TimePoint deadline) {
  if (::shutdown(socket_, SHUT_WR) != 0) return;
  do {
    at_ = buffer_.size();
  } while (Fill(deadline, kBlock));
}

}  // namespace morphograph::internal
