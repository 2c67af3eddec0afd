#include "api/content_negotiation.h"

#include <charconv>

#include "api/http_message.h"

namespace morphograph {
namespace {

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Cuts the text before the next `separator` off `rest`.
std::string_view NextItem(std::string_view* rest, char separator) {
  const std::size_t end = rest->find(separator);
  const std::string_view item = rest->substr(0, end);
  *rest = end == std::string_view::npos ? std::string_view() : rest->substr(end + 1);
  return Trimmed(item);
}

// How precisely a range of an Accept header names a type: 2 exactly, 1 "text/*", 0 "*/*", -1 not at all.
int Precision(std::string_view range, std::string_view type) {
  if (EqualsIgnoringCase(range, type)) return 2;
  if (range == "*/*") return 0;
  if (range.ends_with("/*") && EqualsIgnoringCase(range.substr(0, range.size() - 1), type.substr(0, range.size() - 1)))
    return 1;
  return -1;
}

double QualityOf(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string_view parameter = NextItem(&parameters, ';');
    if (parameter.size() < 3 || !EqualsIgnoringCase(parameter.substr(0, 2), "q=")) continue;
    double quality = 0;
    const auto [end, error] =
        std::from_chars(parameter.data() + 2, parameter.data() + parameter.size(), quality, std::chars_format::fixed);
    return error == std::errc() && quality >= 0 && quality <= 1 ? quality : 0;
  }
  return 1;
}

}  // namespace

int ChooseMediaType(std::string_view accept, const std::vector<std::string_view>& offered) {
  if (Trimmed(accept).empty()) return offered.empty() ? -1 : 0;
  int best = -1;
  double best_quality = 0;
  for (int i = 0; i < static_cast<int>(offered.size()); ++i) {
    // The most precise range that fits a type decides its quality.
    int precision = -1;
    double quality = 0;
    for (std::string_view rest = accept; !rest.empty();) {
      std::string_view parameters = NextItem(&rest, ',');
      const std::string_view range = NextItem(&parameters, ';');
      const int fits = Precision(range, offered[i]);
      if (fits > precision) {
        precision = fits;
        quality = QualityOf(parameters);
      }
    }
    if (quality > best_quality) {
      best = i;
      best_quality = quality;
    }
  }
  return best;
}

std::string_view MediaTypeOf(std::string_view content_type) { return NextItem(&content_type, ';'); }

bool MatchesEntityTag(std::string_view if_none_match, std::string_view entity_tag) {
  while (!if_none_match.empty()) {
    std::string_view tag = NextItem(&if_none_match, ',');
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == "*" || tag == entity_tag) return true;
  }
  return false;
}

}  // namespace morphograph
