#include "api/default_model.h"

#include "graph/model_io.h"

#ifdef MORPHOGRAPH_DEFAULT_MODEL
#include "api/internal/embedded_file.h"
MORPHOGRAPH_EMBED_FILE(DefaultModelBytes, MORPHOGRAPH_DEFAULT_MODEL)
#endif

namespace morphograph {

std::shared_ptr<const MotionGraph> LoadDefaultModel() {
#ifdef MORPHOGRAPH_DEFAULT_MODEL
  return ParseModel(DefaultModelBytes(), "the embedded model");
#else
  return nullptr;
#endif
}

}  // namespace morphograph
