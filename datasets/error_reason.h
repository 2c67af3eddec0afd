#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace morphograph {

/// An exception's text for people: without the function's name that our std::invalid_argument texts begin with ("Retarget: the rest
/// pose ..."), which means nothing to them.
inline std::string ReasonOf(const std::exception& error) {
  const std::string_view text = error.what();
  const std::size_t end = text.find(": ");
  if (end == std::string_view::npos || end == 0 || text[0] < 'A' || text[0] > 'Z') return std::string(text);
  bool has_lower = false;
  for (const char c : text.substr(0, end)) {
    const bool lower = c >= 'a' && c <= 'z';
    const bool other = (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ':';
    if (!lower && !other) return std::string(text);
    has_lower |= lower;
  }
  return std::string(has_lower ? text.substr(end + 2) : text);
}

}  // namespace morphograph
