#include "api/router.h"

#include <optional>

#include "api/problem.h"

namespace morphograph {
namespace {

std::vector<std::string_view> Segments(std::string_view path) {
  std::vector<std::string_view> segments;
  path.remove_prefix(1);  // the leading slash
  while (true) {
    const std::size_t end = path.find('/');
    segments.push_back(path.substr(0, end));
    if (end == std::string_view::npos) return segments;
    path.remove_prefix(end + 1);
  }
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string PercentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const bool whole = i + 2 < text.size();
    const int high = whole ? HexDigit(text[i + 1]) : -1;
    const int low = whole ? HexDigit(text[i + 2]) : -1;
    if (high < 0 || low < 0) throw ProblemError(400, "the path has a broken percent escape");
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

// The arguments when `path` fits `pattern`.
std::optional<std::vector<std::string>> Fit(std::string_view pattern, std::string_view path) {
  const std::vector<std::string_view> wanted = Segments(pattern), given = Segments(path);
  std::vector<std::string> arguments;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (i >= given.size()) return std::nullopt;
    if (wanted[i].ends_with("...}")) {
      arguments.push_back(PercentDecoded(path.substr(static_cast<std::size_t>(given[i].data() - path.data()))));
      return arguments;
    }
    if (wanted[i].starts_with("{")) {
      if (given[i].empty()) return std::nullopt;
      arguments.push_back(PercentDecoded(given[i]));
    } else if (wanted[i] != given[i]) {
      return std::nullopt;
    }
  }
  if (given.size() != wanted.size()) return std::nullopt;
  return arguments;
}

}  // namespace

Router::Router(std::vector<Route> routes) : routes_(std::move(routes)) {}

std::string Router::Allowed(std::string_view path) const {
  std::string allowed;
  for (const Route& route : routes_) {
    if (!Fit(route.pattern, path)) continue;
    allowed += route.method + ", ";
    if (route.method == "GET") allowed += "HEAD, ";
  }
  return allowed.empty() ? allowed : allowed + "OPTIONS";
}

Router::Match Router::Find(std::string_view method, std::string_view path) const {
  if (!path.starts_with('/')) throw ProblemError(400, "the request target must be a path");
  const std::string_view wanted = method == "HEAD" ? "GET" : method;
  for (const Route& route : routes_) {
    if (route.method != wanted) continue;
    if (auto arguments = Fit(route.pattern, path)) return {&route, std::move(*arguments)};
  }
  const std::string allowed = Allowed(path);
  if (allowed.empty()) throw ProblemError(404, "there is nothing at " + Excerpt(path));
  Problem problem;
  problem.status = 405;
  problem.detail = "this path takes " + allowed;
  problem.allow = allowed;
  throw ProblemError(std::move(problem));
}

}  // namespace morphograph
