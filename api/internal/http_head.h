#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace morphograph::internal {

inline constexpr std::size_t kMaxHeadBytes = 16 * 1024;  // request line and headers
inline constexpr std::size_t kMaxTargetBytes = 8 * 1024;

/// A request's line and headers, checked before any other parser sees them.
struct HttpHead {
  std::string method;
  std::string target;
  std::string path;  // of the target: without scheme and authority, without the query
  int minor_version = 1;  // HTTP/1.x
  std::vector<std::pair<std::string, std::string>> headers;
  std::uint64_t body_bytes = 0;
  bool is_chunked = false;  // the body comes in chunks, and says itself where it ends
  bool keep_alive = true;
  bool expects_continue = false;

  std::size_t Count(std::string_view name) const;
  /// First header of that name, whatever its case; empty when absent.
  std::string_view Value(std::string_view name) const;
};

/// Reads a head (RFC 9112, 2 to 6) more strictly than the RFC asks: lines end with CRLF only, nothing is folded, and
/// only one framing is taken, one Content-Length or one "Transfer-Encoding: chunked" (which few routes take). Two readers that disagree on where a body ends could be played off
/// against each other (request smuggling).
///
/// @param text  from the request line to the CRLF of the last header, without the empty line.
/// @param head  filled as far as the text could be read, also when an error is thrown.
/// @throws ProblemError: 400 malformed, 411 transfer coded otherwise, 414 long target, 415 coded body, 417 unknown expectation,
///         505 other version.
void ParseHttpHead(std::string_view text, HttpHead* head);

/// @throws ProblemError when bytes without a complete head cannot become one: 400 not HTTP at all, 414 or 431 too long.
void CheckUnfinishedHead(std::string_view bytes);

}  // namespace morphograph::internal
