#pragma once

#include <string>
#include <string_view>

namespace morphograph {

/// XXH3, 128 bits, as 32 hex digits: names content, guards nothing.
std::string ContentHash(std::string_view bytes);

}  // namespace morphograph
