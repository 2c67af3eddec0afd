#include "api/viewer_assets.h"

#include <array>

// The assembler embeds the files as they are: a bundle of 0.7 MB as a C++ literal would cost seconds to compile.
// The labels are global, because link-time optimisation may move users of them into other units.
#define MORPHOGRAPH_EMBED(name, file)                                                               \
  asm(".pushsection .rodata\n"                                                                      \
      ".global morphograph_viewer_" #name "_begin\n.global morphograph_viewer_" #name "_end\n"      \
      "morphograph_viewer_" #name "_begin:\n.incbin \"" MORPHOGRAPH_VIEWER_FILES "/" file "\"\n"    \
      "morphograph_viewer_" #name "_end:\n.byte 0\n.popsection\n");                                 \
  extern "C" const char morphograph_viewer_##name##_begin[];                                        \
  extern "C" const char morphograph_viewer_##name##_end[];                                          \
  static std::string_view name() {                                                                  \
    return {morphograph_viewer_##name##_begin,                                                      \
            static_cast<std::size_t>(morphograph_viewer_##name##_end - morphograph_viewer_##name##_begin)}; \
  }

#ifdef MORPHOGRAPH_VIEWER_BUNDLED
MORPHOGRAPH_EMBED(Page, "index.html")
MORPHOGRAPH_EMBED(Script, "app.js")
MORPHOGRAPH_EMBED(Style, "app.css")
MORPHOGRAPH_EMBED(Icon, "favicon.svg")
MORPHOGRAPH_EMBED(Licences, "third_party.txt")
#else
MORPHOGRAPH_EMBED(Page, "not_built.html")
#endif

namespace morphograph {

std::span<const ViewerAsset> ViewerAssets() {
  static const std::array assets = {
      ViewerAsset{"/", "text/html; charset=utf-8", Page()},
#ifdef MORPHOGRAPH_VIEWER_BUNDLED
      ViewerAsset{"/app.js", "text/javascript; charset=utf-8", Script()},
      ViewerAsset{"/app.css", "text/css; charset=utf-8", Style()},
      ViewerAsset{"/favicon.svg", "image/svg+xml", Icon()},
      ViewerAsset{"/third_party.txt", "text/plain; charset=utf-8", Licences()},
#endif
  };
  return assets;
}

}  // namespace morphograph
