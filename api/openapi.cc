#include "api/openapi.h"

#include "api/internal/embedded_file.h"

MORPHOGRAPH_EMBED_FILE(OpenApiFile, MORPHOGRAPH_OPENAPI_FILE)

namespace morphograph {

const std::string& OpenApiJson() {
  static const std::string text(OpenApiFile());
  return text;
}

}  // namespace morphograph
