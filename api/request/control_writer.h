#pragma once

#include <nlohmann/json.hpp>

#include "synthesis/control/control_terms.h"

namespace morphograph {

/// Adds "path", "goal", "speed" and "constraints" to a request, in the form that ReadControlTerms() takes: fixed order of fields, defaults
/// left out, so that equal terms have equal text.
void WriteControlTerms(const ControlTerms& terms, nlohmann::ordered_json* request);

}  // namespace morphograph
