#include "api/json_guard.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "api/problem.h"

namespace morphograph {
namespace {

// Deepest nesting of brackets outside strings. Text that is not JSON may count wrongly; the parser refuses it.
int NestingDepth(std::string_view text) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        in_string = false;
      }
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

[[noreturn]] void Refuse(std::string detail) {
  throw ProblemError(Problem{400, "the body is not valid JSON", {{"", std::move(detail)}}, {}, {}});
}

// "[json.exception.parse_error.101] parse error at line 1, column 2: …" without the library's prefix.
std::string PlainMessage(std::string_view what) {
  if (const std::size_t end = what.find("] "); what.starts_with('[') && end != std::string_view::npos)
    what.remove_prefix(end + 2);
  return Excerpt(what, 240);
}

}  // namespace

nlohmann::json ParseUntrustedJson(std::string_view text, const JsonLimits& limits) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) Refuse("it is empty");
  if (NestingDepth(text) > limits.max_depth)
    Refuse("it is nested deeper than " + std::to_string(limits.max_depth) + " levels");

  std::vector<std::set<std::string>> open_objects;
  const auto refuse_repeated_names = [&](int, nlohmann::json::parse_event_t event, nlohmann::json& value) {
    if (event == nlohmann::json::parse_event_t::object_start) {
      open_objects.emplace_back();
    } else if (event == nlohmann::json::parse_event_t::object_end) {
      open_objects.pop_back();
    } else if (event == nlohmann::json::parse_event_t::key) {
      const auto& name = value.get_ref<const std::string&>();
      if (!open_objects.back().insert(name).second) Refuse("the field \"" + Excerpt(name) + "\" stands twice");
    }
    return true;
  };
  try {
    return nlohmann::json::parse(text.begin(), text.end(), refuse_repeated_names);
  } catch (const nlohmann::json::exception& error) {  // syntax, invalid UTF-8, numbers past the range of a double
    Refuse(PlainMessage(error.what()));
  }
}

}  // namespace morphograph
