#pragma once

#include <string>
#include <string_view>

namespace morphograph {

/// Whether bytes are well-formed UTF-8 (RFC 3629: shortest forms, no surrogates, up to U+10FFFF).
bool IsUtf8(std::string_view bytes);

/// Names as everything behind the readers holds them, JSON and GLB included: UTF-8 as it is, anything else read as Latin-1, byte for
/// character, which older exporters write.
std::string Utf8FromUnknown(std::string_view bytes);

}  // namespace morphograph
