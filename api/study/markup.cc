#include "api/study/markup.h"

#include <cmath>
#include <cstdio>

#include "datasets/text_encoding.h"

namespace morphograph {

std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : Utf8FromUnknown(text)) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&#39;"; break;
      case '\n': case '\t': escaped += c; break;
      default: escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;  // XML knows no other control characters
    }
  }
  return escaped;
}

std::string ShortNumber(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  if (value == 0) return "0";
  char text[40];
  const double size = std::abs(value);
  if (size < 1e-4 || size >= 1e7) {
    std::snprintf(text, sizeof text, "%.*e", digits - 1, value);
    std::string written(text);
    const size_t e = written.find('e');
    std::string mantissa = written.substr(0, e);
    if (mantissa.find('.') != std::string::npos) mantissa.erase(mantissa.find_last_not_of("0.") + 1);
    return mantissa + "e" + std::to_string(std::stoi(written.substr(e + 1)));
  }
  const int decimals = std::max(0, digits - 1 - static_cast<int>(std::floor(std::log10(size))));
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string written(text);
  if (written.find('.') != std::string::npos) {
    written.erase(written.find_last_not_of('0') + 1);
    if (written.back() == '.') written.pop_back();
  }
  return written == "-0" ? "0" : written;
}

std::string FixedNumber(double value, int decimals) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

}  // namespace morphograph
