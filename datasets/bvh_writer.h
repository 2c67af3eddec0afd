#pragma once

#include <string>

#include "datasets/bvh_document.h"

namespace morphograph {

struct BvhWriteOptions {
  int decimals = 6;  // of every value; the frame time has at least 7 digits
};

/// BVH text, `\n` line ends, locale-independent. @throws std::invalid_argument on inconsistent sizes or
/// values that are not finite.
std::string WriteBvh(const BvhDocument& document, const BvhWriteOptions& options = {});

}  // namespace morphograph
