#pragma once

#include <nlohmann/json.hpp>

#include "api/clip_request.h"
#include "api/request/findings.h"

namespace morphograph {

/// Reads a request's "output": frame rate, channels, unit. Bounds of the frame rate are the caller's to check.
OutputFormat ReadOutputFormat(const nlohmann::json& object, Findings* findings);

}  // namespace morphograph
