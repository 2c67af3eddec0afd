#pragma once

#include <string_view>
#include <vector>

namespace morphograph {

/// Picks what to answer from an Accept header (RFC 9110, 12.5.1).
///
/// @param accept  the header's value; empty means anything.
/// @param offered  media types, the server's favourite first; ties go to the earlier.
/// @return index into `offered`, or -1 when nothing suits.
int ChooseMediaType(std::string_view accept, const std::vector<std::string_view>& offered);

/// A media type without its parameters, trimmed: "text/plain; charset=utf-8" -> "text/plain".
std::string_view MediaTypeOf(std::string_view content_type);

/// Whether an If-None-Match header names this entity tag (weak comparison) or is "*".
bool MatchesEntityTag(std::string_view if_none_match, std::string_view entity_tag);

}  // namespace morphograph
