#pragma once

#include <string>

#include "api/clip_request.h"
#include "synthesis/variant_set.h"

namespace morphograph {

/// One line of a set of variants: `{"index": …, "seed": …, "bvh": …, "report": …}`, without its end.
std::string VariantLine(const ClipVariant& variant, const OutputFormat& output);

/// What `{"summary": …}` holds: metres, seconds, square metres; lengths rounded to 0.01 mm.
std::string VariantSummaryJson(const VariantSummary& summary);

}  // namespace morphograph
