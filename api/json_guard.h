#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace morphograph {

struct JsonLimits {
  int max_depth = 32;
};

/// Parses JSON that a stranger sent.
///
/// Nesting is measured before anything is parsed, so that depth never costs stack or memory. Strict RFC 8259: no
/// comments, no trailing text; a member name that stands twice in one object is an error, since readers
/// disagree on which one counts.
/// @throws ProblemError (400) saying where and why.
nlohmann::json ParseUntrustedJson(std::string_view text, const JsonLimits& limits = {});

}  // namespace morphograph
