#include "api/study/svg_writer.h"

#include <cmath>
#include <cstdio>

#include "api/study/markup.h"

namespace morphograph {

std::string SvgNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", std::abs(value) < 0.05 ? 0.0 : value);
  std::string written(text);
  if (written.ends_with(".0")) written.resize(written.size() - 2);
  return written;
}

void SvgPath::MoveTo(double x, double y) {
  last_ = SvgNumber(x) + "," + SvgNumber(y);
  data_ += "M" + last_;
}

void SvgPath::LineTo(double x, double y) {
  std::string place = SvgNumber(x) + "," + SvgNumber(y);
  if (place == last_) return;
  data_ += "L" + place;
  last_ = std::move(place);
}

void SvgPath::Close() {
  data_ += "Z";
  last_.clear();
}

void SvgPath::Dot(double x, double y) {
  const std::string place = SvgNumber(x) + "," + SvgNumber(y);
  data_ += "M" + place + "h0";
  last_ = place;
}

void SvgPath::Rectangle(double x, double y, double width, double height) {
  MoveTo(x, y);
  data_.append("h").append(SvgNumber(width)).append("v").append(SvgNumber(height)).append("h").append(SvgNumber(-width)).append("Z");
  last_.clear();
}

std::string SvgText(double x, double y, std::string_view text, SvgAnchor anchor, std::string_view kind, double turn_deg) {
  std::string element = "<text x=\"" + SvgNumber(x) + "\" y=\"" + SvgNumber(y) + "\"";
  if (anchor != SvgAnchor::kStart) element += anchor == SvgAnchor::kMiddle ? " text-anchor=\"middle\"" : " text-anchor=\"end\"";
  if (!kind.empty()) element += " class=\"" + std::string(kind) + "\"";
  if (turn_deg != 0) element += " transform=\"rotate(" + SvgNumber(turn_deg) + " " + SvgNumber(x) + " " + SvgNumber(y) + ")\"";
  return element + ">" + Escaped(text) + "</text>";
}

std::string SvgPathElement(const SvgPath& path, std::string_view kind) {
  return path.is_empty() ? "" : "<path class=\"" + std::string(kind) + "\" d=\"" + path.data() + "\"/>";
}

std::string SvgLine(double x1, double y1, double x2, double y2, std::string_view kind) {
  return "<path class=\"" + std::string(kind) + "\" d=\"M" + SvgNumber(x1) + "," + SvgNumber(y1) + "L" + SvgNumber(x2) + "," +
         SvgNumber(y2) + "\"/>";
}

double SvgTextWidth(std::string_view text, double size) {
  double width = 0;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0) == 0x80) continue;  // the rest of a character
    const bool narrow = c == 'i' || c == 'l' || c == 'j' || c == 't' || c == 'f' || c == 'r' || c == ' ' || c == '.' || c == ',' || c == '\'';
    const bool wide = c == 'm' || c == 'w' || (c >= 'A' && c <= 'Z');
    width += narrow ? 0.32 : wide ? 0.78 : 0.57;
  }
  return width * size;
}

std::vector<std::string> SvgWrapped(std::string_view text, double size, double width) {
  std::vector<std::string> lines;
  for (size_t from = 0; from < text.size();) {
    const size_t to = std::min(text.find(' ', from), text.size());
    const std::string word(text.substr(from, to - from));
    from = to + 1;
    if (word.empty()) continue;
    if (lines.empty() || SvgTextWidth(lines.back() + " " + word, size) > width) {
      lines.push_back(word);
    } else {
      lines.back() += " " + word;
    }
  }
  return lines;
}

}  // namespace morphograph
