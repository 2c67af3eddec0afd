// GET / and the files of the viewer page
#include "api/content_hash.h"
#include "api/content_negotiation.h"
#include "api/routes.h"
#include "api/viewer_assets.h"

namespace morphograph {

std::vector<Route> ViewerRoutes() {
  std::vector<Route> routes;
  for (const ViewerAsset& asset : ViewerAssets()) {
    const auto serve = [asset, tag = '"' + ContentHash(asset.body) + '"'](const HttpRequest& request) {
      HttpResponse response;
      response.Set("ETag", tag);
      response.Set("Cache-Control", "no-cache");
      response.Set("Content-Security-Policy", std::string(kViewerContentSecurityPolicy));
      response.Set("Referrer-Policy", "no-referrer");
      response.Set("Cross-Origin-Opener-Policy", "same-origin");
      if (MatchesEntityTag(request.Header("If-None-Match"), tag)) {
        response.status = 304;
        return response;
      }
      response.Set("Content-Type", std::string(asset.content_type));
      response.body = std::string(asset.body);
      return response;
    };
    routes.push_back({"GET", std::string(asset.path), serve, 0, true});
  }
  return routes;
}

}  // namespace morphograph
