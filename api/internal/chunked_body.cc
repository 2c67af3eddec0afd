#include "api/internal/chunked_body.h"

#include <algorithm>
#include <charconv>

#include "api/problem.h"

namespace morphograph::internal {
namespace {

constexpr std::size_t kMostDigits = 6;  // chunks below 16 MiB
constexpr std::size_t kPiece = 64 * 1024;
constexpr std::chrono::milliseconds kLook{200};  // whether the server is to stop

[[noreturn]] void ThrowBadChunks() { throw ProblemError(400, "the body's chunks are not well formed"); }

}  // namespace

// Until so many bytes are buffered.
void ChunkedBody::WaitFor(std::size_t bytes) {
  while (socket_->buffered().size() < bytes) {
    const auto now = std::chrono::steady_clock::now();
    if (*stopping_) throw ProblemError(503, "the server is about to stop");
    if (now >= deadline_) throw ProblemError(408, "no line came for " + std::to_string(patience_.count()) + " seconds");
    if (!socket_->Fill(std::min(deadline_, now + kLook), kPiece) && socket_->IsClosedByPeer()) throw ProblemError(400, "the body was cut short");
  }
}

// The line before a chunk, and the end of the chunk before it.
void ChunkedBody::ReadSize() {
  if (!first_) {
    WaitFor(2);
    if (!socket_->buffered().starts_with("\r\n")) ThrowBadChunks();
    socket_->Consume(2);
  }
  first_ = false;
  std::size_t digits = 0;
  while (true) {
    WaitFor(digits + 1);
    if (socket_->buffered()[digits] == '\r') break;
    if (++digits > kMostDigits) ThrowBadChunks();
  }
  WaitFor(digits + 2);
  const std::string_view line = socket_->buffered().substr(0, digits + 2);
  const auto [stop, error] = std::from_chars(line.data(), line.data() + digits, left_, 16);
  if (digits == 0 || error != std::errc() || stop != line.data() + digits || line[digits + 1] != '\n') ThrowBadChunks();
  socket_->Consume(digits + 2);
  if (left_ > 0) return;
  ended_ = true;
  WaitFor(2);
  if (!socket_->buffered().starts_with("\r\n")) ThrowBadChunks();  // trailers are not taken
  socket_->Consume(2);
}

std::string ChunkedBody::Next() {
  if (left_ == 0 && !ended_) ReadSize();
  if (ended_) return {};
  WaitFor(1);
  const std::size_t taken = std::min(left_, socket_->buffered().size());
  std::string piece(socket_->buffered().substr(0, taken));
  socket_->Consume(taken);
  left_ -= taken;
  if (piece.find('\n') != std::string::npos) deadline_ = std::chrono::steady_clock::now() + patience_;
  return piece;
}

}  // namespace morphograph::internal
