#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace morphograph {

/// One part of a multipart/form-data body; views into the body.
struct MultipartPart {
  std::string name;
  std::string file_name;  // as sent, never to be used as a path
  std::string_view content;
};

struct MultipartLimits {
  std::size_t max_parts = 2100;
  std::size_t max_part_head = 4096;  // bytes of one part's headers
};

/// Splits a multipart/form-data body (RFC 7578). Linear in the body's size.
/// @param content_type  the request's header, with its boundary.
/// @throws ProblemError: 415 for another type, 400 for a malformed body.
std::vector<MultipartPart> ParseMultipart(std::string_view content_type, std::string_view body,
                                          const MultipartLimits& limits = {});

}  // namespace morphograph
