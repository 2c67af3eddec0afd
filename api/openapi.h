#pragma once

#include <string>

namespace morphograph {

/// The description of the HTTP interface, OpenAPI 3.1 (api/openapi.json).
const std::string& OpenApiJson();

}  // namespace morphograph
