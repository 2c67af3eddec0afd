#include "api/internal/http_head.h"

#include <algorithm>
#include <charconv>

#include "api/http_message.h"
#include "api/problem.h"

namespace morphograph::internal {
namespace {

bool IsAlphanumeric(char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

// tchar (RFC 9110, 5.6.2).
bool IsTokenChar(char c) { return IsAlphanumeric(c) || std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos; }

bool IsToken(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), IsTokenChar); }

bool IsControl(char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f; }

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool HasListMember(std::string_view list, std::string_view member) {
  while (true) {
    const std::size_t comma = list.find(',');
    if (EqualsIgnoringCase(Trimmed(list.substr(0, comma)), member)) return true;
    if (comma == std::string_view::npos) return false;
    list.remove_prefix(comma + 1);
  }
}

[[noreturn]] void ThrowMalformed() { throw ProblemError(400, "this is not a well-formed HTTP request"); }

[[noreturn]] void ThrowLongTarget() {
  throw ProblemError(414, "the request target exceeds " + std::to_string(kMaxTargetBytes) + " bytes");
}

void ParseRequestLine(std::string_view line, HttpHead* head) {
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) ThrowMalformed();
  const std::string_view method = line.substr(0, first), version = line.substr(last + 1);
  std::string_view target = line.substr(first + 1, last - first - 1);
  const auto is_visible = [](char c) { return !IsControl(c) && c != ' ' && c != '\t'; };
  if (!IsToken(method) || target.empty() || !std::all_of(target.begin(), target.end(), is_visible)) ThrowMalformed();
  if (!version.starts_with("HTTP/")) ThrowMalformed();
  head->method = method;
  if (target.size() > kMaxTargetBytes) ThrowLongTarget();
  head->target = target;
  if (version != "HTTP/1.0" && version != "HTTP/1.1")
    throw ProblemError(505, "only HTTP/1.0 and HTTP/1.1 are spoken here");
  head->minor_version = version.back() - '0';
  // Absolute form: the authority is ours, whatever it says (RFC 9112, 3.2.2).
  if (target.starts_with("http://")) target.remove_prefix(std::min(target.find('/', 7), target.size()));
  head->path = target.substr(0, target.find('?'));
}

void ParseHeader(std::string_view line, HttpHead* head) {
  // A name with a space before its colon, or a folded line, is a token to no reader, but a header to some.
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !IsToken(line.substr(0, colon))) ThrowMalformed();
  if (std::any_of(line.begin(), line.end(), IsControl)) ThrowMalformed();
  head->headers.emplace_back(line.substr(0, colon), Trimmed(line.substr(colon + 1)));
}

void CheckFraming(HttpHead* head) {
  const std::size_t lengths = head->Count("Content-Length");
  if (const std::size_t codings = head->Count("Transfer-Encoding"); codings > 0) {
    head->is_chunked = codings == 1 && lengths == 0 && head->minor_version == 1 && EqualsIgnoringCase(head->Value("Transfer-Encoding"), "chunked");
    if (!head->is_chunked) throw ProblemError(411, "otherwise coded transfers than chunked ones are not taken; send a Content-Length");
  }
  if (lengths > 1) throw ProblemError(400, "Content-Length stands twice");
  if (lengths == 1) {
    const std::string_view text = head->Value("Content-Length");
    const char* end = text.data() + text.size();
    // from_chars takes no sign but '-', which an unsigned number refuses.
    const auto [stop, error] = std::from_chars(text.data(), end, head->body_bytes);
    if (text.empty() || error != std::errc() || stop != end) {
      head->body_bytes = 0;
      throw ProblemError(400, "Content-Length is not one number");
    }
  }
  if (head->Count("Content-Encoding") > 0) throw ProblemError(415, "coded bodies are not taken; send the body as it is");
  if (head->minor_version == 1 && head->Count("Host") != 1)
    throw ProblemError(400, "HTTP/1.1 needs exactly one Host header");
  head->expects_continue = head->Count("Expect") > 0;
  if (head->expects_continue && !EqualsIgnoringCase(head->Value("Expect"), "100-continue"))
    throw ProblemError(417, "the only expectation met here is 100-continue");
}

}  // namespace

std::size_t HttpHead::Count(std::string_view name) const {
  return static_cast<std::size_t>(std::count_if(headers.begin(), headers.end(), [&](const auto& header) {
    return EqualsIgnoringCase(header.first, name);
  }));
}

std::string_view HttpHead::Value(std::string_view name) const {
  for (const auto& [key, value] : headers)
    if (EqualsIgnoringCase(key, name)) return value;
  return {};
}

void ParseHttpHead(std::string_view text, HttpHead* head) {
  bool is_first = true;
  while (!text.empty()) {
    const std::size_t end = text.find("\r\n");
    if (end == std::string_view::npos) ThrowMalformed();
    if (is_first) {
      ParseRequestLine(text.substr(0, end), head);
    } else {
      ParseHeader(text.substr(0, end), head);
    }
    is_first = false;
    text.remove_prefix(end + 2);
  }
  if (is_first) ThrowMalformed();
  head->keep_alive = head->minor_version == 1;
  for (const auto& [name, value] : head->headers) {
    if (!EqualsIgnoringCase(name, "Connection")) continue;
    if (HasListMember(value, "keep-alive")) head->keep_alive = true;
  }
  for (const auto& [name, value] : head->headers)
    if (EqualsIgnoringCase(name, "Connection") && HasListMember(value, "close")) head->keep_alive = false;
  CheckFraming(head);
}

void CheckUnfinishedHead(std::string_view bytes) {
  // Whoever speaks another protocol (TLS, say) may wait for an answer and never send the end of a head.
  const std::size_t line_end = bytes.find("\r\n");
  const std::string_view line = bytes.substr(0, line_end);
  if (!line.empty() && !IsTokenChar(line.front())) ThrowMalformed();
  if (bytes.size() <= kMaxHeadBytes) return;
  if (line.size() > kMaxTargetBytes) ThrowLongTarget();
  throw ProblemError(431, "request line and headers exceed " + std::to_string(kMaxHeadBytes) + " bytes");
}

}  // namespace morphograph::internal
