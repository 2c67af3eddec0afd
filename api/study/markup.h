#pragma once

#include <string>
#include <string_view>

namespace morphograph {

/// Text for the content or a quoted attribute of HTML or SVG: marks that would be taken as markup are written as entities, bytes that are
/// no UTF-8 and control characters as something harmless.
std::string Escaped(std::string_view text);

/// A number for people: `digits` significant ones, no trailing zeros, a power of ten only for the very small and the very large; "–" where
/// it is not finite.
std::string ShortNumber(double value, int digits = 3);

/// A number with a fixed number of decimals.
std::string FixedNumber(double value, int decimals = 2);

}  // namespace morphograph
