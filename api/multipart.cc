#include "api/multipart.h"

#include "api/content_negotiation.h"
#include "api/http_message.h"
#include "api/problem.h"

namespace morphograph {
namespace {

[[noreturn]] void Malformed(const std::string& why) {
  throw ProblemError(400, "the multipart body is malformed: " + why);
}

// Value of a parameter of a header such as `form-data; name="a"; filename="b.bvh"`; quotes and escapes removed.
std::string Parameter(std::string_view header, std::string_view wanted) {
  std::size_t at = header.find(';');
  while (at != std::string_view::npos && at < header.size()) {
    ++at;
    while (at < header.size() && (header[at] == ' ' || header[at] == '\t')) ++at;
    const std::size_t equals = header.find_first_of("=;", at);
    if (equals == std::string_view::npos || header[equals] == ';') {
      at = equals;
      continue;
    }
    const std::string_view name = header.substr(at, equals - at);
    std::string value;
    at = equals + 1;
    if (at < header.size() && header[at] == '"') {
      for (++at; at < header.size() && header[at] != '"'; ++at) {
        if (header[at] == '\\' && at + 1 < header.size() && (header[at + 1] == '"' || header[at + 1] == '\\')) ++at;
        value += header[at];
      }
      at = header.find(';', at);
    } else {
      const std::size_t end = header.find(';', at);
      value = std::string(header.substr(at, end == std::string_view::npos ? end : end - at));
      while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.pop_back();
      at = end;
    }
    if (EqualsIgnoringCase(name, wanted)) return value;
  }
  return {};
}

MultipartPart PartFrom(std::string_view head, std::string_view content) {
  MultipartPart part;
  part.content = content;
  bool disposed = false;
  while (!head.empty()) {
    const std::size_t end = head.find("\r\n");
    const std::string_view line = head.substr(0, end);
    head = end == std::string_view::npos ? std::string_view() : head.substr(end + 2);
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) Malformed("a part has a header line without a colon");
    const std::string_view name = line.substr(0, colon), value = line.substr(colon + 1);
    if (EqualsIgnoringCase(name, "Content-Disposition")) {
      if (!EqualsIgnoringCase(MediaTypeOf(value), "form-data")) Malformed("a part is not form-data");
      part.name = Parameter(value, "name");
      part.file_name = Parameter(value, "filename");
      disposed = true;
    } else if (EqualsIgnoringCase(name, "Content-Transfer-Encoding") && !EqualsIgnoringCase(MediaTypeOf(value), "binary") &&
               !EqualsIgnoringCase(MediaTypeOf(value), "8bit") && !EqualsIgnoringCase(MediaTypeOf(value), "7bit")) {
      Malformed("a part has a transfer encoding");
    }
  }
  if (!disposed || part.name.empty()) Malformed("a part has no name");
  return part;
}

}  // namespace

std::vector<MultipartPart> ParseMultipart(std::string_view content_type, std::string_view body,
                                          const MultipartLimits& limits) {
  if (!EqualsIgnoringCase(MediaTypeOf(content_type), "multipart/form-data"))
    throw ProblemError(415, "this takes multipart/form-data, not " + Excerpt(MediaTypeOf(content_type)));
  const std::string boundary = Parameter(content_type, "boundary");
  if (boundary.empty() || boundary.size() > 70) Malformed("its boundary must have 1 to 70 characters");

  const std::string delimiter = "\r\n--" + boundary;
  // The first delimiter may stand at the very start, without its line break.
  std::size_t at = 0;
  if (body.starts_with(std::string_view(delimiter).substr(2))) {
    at = delimiter.size() - 2;
  } else if (const std::size_t first = body.find(delimiter); first != std::string_view::npos) {
    at = first + delimiter.size();
  } else {
    Malformed("its boundary does not occur");
  }
  std::vector<MultipartPart> parts;
  while (true) {
    if (body.substr(at, 2) == "--") return parts;
    while (at < body.size() && (body[at] == ' ' || body[at] == '\t')) ++at;
    if (body.substr(at, 2) != "\r\n") Malformed("a boundary line has more text");
    at += 2;
    const std::size_t head_end = body.substr(at, limits.max_part_head).find("\r\n\r\n");
    if (head_end == std::string_view::npos) Malformed("a part's headers do not end");
    const std::size_t start = at + head_end + 4;
    // A part may be empty: then its delimiter's line break is the one that ends the headers.
    const std::size_t end = body.find(delimiter, start - 2);
    if (end == std::string_view::npos) Malformed("the last boundary is missing");
    if (parts.size() == limits.max_parts) Malformed("more than " + std::to_string(limits.max_parts) + " parts");
    parts.push_back(PartFrom(body.substr(at, head_end), end < start ? std::string_view() : body.substr(start, end - start)));
    at = end + delimiter.size();
  }
}

}  // namespace morphograph
