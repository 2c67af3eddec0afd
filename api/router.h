#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "api/http_message.h"

namespace morphograph {

/// One method on one path of the interface.
struct Route {
  std::string method;
  std::string pattern;           // "/v1/clips/{id}"; a last segment "{name...}" takes the rest, slashes included
  std::function<HttpResponse(const HttpRequest&)> handler;
  std::size_t max_body = 0;      // bytes; 0: takes no body
  bool immediate = false;        // cheap enough to answer before all queued work
  std::string live_type = {};    // media type of bodies that may come in chunks while they are being answered; empty: none
};

/// The routes of the interface. Built once, then read from any thread.
class Router {
 public:
  explicit Router(std::vector<Route> routes);

  struct Match {
    const Route* route = nullptr;
    std::vector<std::string> arguments;
  };

  /// The route for a method and path (without query); HEAD finds GET.
  /// @throws ProblemError: 400 for a broken percent escape, 404 for an unknown path, 405 with the methods allowed.
  Match Find(std::string_view method, std::string_view path) const;

  /// Methods known for a path, "GET, HEAD, OPTIONS"; empty when the path is unknown.
  std::string Allowed(std::string_view path) const;

  const std::vector<Route>& routes() const { return routes_; }

 private:
  std::vector<Route> routes_;
};

}  // namespace morphograph
