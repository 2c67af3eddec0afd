#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace morphograph {

/// A request as handlers see it: already framed, bounded and routed.
struct HttpRequest {
  std::string method;  // "GET", …; HEAD arrives as GET
  std::string path;    // as sent, without the query
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  std::vector<std::string> arguments;  // what the route's {…} stand for, percent-decoded

  /// First header of that name, whatever its case; empty when absent.
  std::string_view Header(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;  // Content-Length, Date and Connection are the server's
  std::string body;

  void Set(std::string name, std::string value) { headers.emplace_back(std::move(name), std::move(value)); }
  std::string_view Header(std::string_view name) const;
};

/// ASCII comparison without case, whatever the locale.
bool EqualsIgnoringCase(std::string_view a, std::string_view b);

}  // namespace morphograph
