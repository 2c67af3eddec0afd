#pragma once

#include <filesystem>
#include <string>

#include "datasets/bvh_document.h"

namespace morphograph {

struct BvhWriteOptions {
  int decimals = 6;  // of every value; the frame time has at least 7 digits
};

/// BVH text, `\n` line ends, locale-independent. @throws std::invalid_argument on inconsistent sizes or
/// values that are not finite.
std::string WriteBvh(const BvhDocument& document, const BvhWriteOptions& options = {});

/// Writes text to a file atomically (temporary file beside it, then rename): a failure leaves no partial
/// file behind and an existing one whole. @throws DatasetError naming the path and the system's reason.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace morphograph
