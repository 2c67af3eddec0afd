#pragma once

#include <span>
#include <string_view>

namespace morphograph {

/// A file of the viewer page, embedded in the program.
struct ViewerAsset {
  std::string_view path;          // as in the URL: "/" is the page itself, "/app.js", …
  std::string_view content_type;  // with charset where it is text
  std::string_view body;
};

/// All files of the page; the bytes live as long as the program. Built without npm there is only a page at "/" that says so.
std::span<const ViewerAsset> ViewerAssets();

/// The Content-Security-Policy that the page is written for, to be sent with each of its files: nothing is ever loaded
/// from another host, and no script or style stands inside the page.
inline constexpr std::string_view kViewerContentSecurityPolicy =
    "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";

}  // namespace morphograph
