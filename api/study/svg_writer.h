#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace morphograph {

/// A length or position in a drawing, at most one decimal: a tenth of its unit is less than a pixel.
std::string SvgNumber(double value);

/// The attribute `d` of a path, in absolute coordinates. Points closer than a tenth to the last one are left out.
class SvgPath {
 public:
  void MoveTo(double x, double y);
  void LineTo(double x, double y);
  void Close();
  /// A dot, drawn by the round caps of the stroke.
  void Dot(double x, double y);
  void Rectangle(double x, double y, double width, double height);
  bool is_empty() const { return data_.empty(); }
  const std::string& data() const { return data_; }

 private:
  std::string data_, last_;
};

enum class SvgAnchor { kStart, kMiddle, kEnd };

/// @param kind  class of the element, may be empty. @param turn_deg  clockwise, about (x, y).
std::string SvgText(double x, double y, std::string_view text, SvgAnchor anchor = SvgAnchor::kStart, std::string_view kind = "",
                    double turn_deg = 0);
std::string SvgPathElement(const SvgPath& path, std::string_view kind);
std::string SvgLine(double x1, double y1, double x2, double y2, std::string_view kind);

/// About how wide a text of a size comes out: no font is measured.
double SvgTextWidth(std::string_view text, double size);

/// Words in lines of at most this width where words allow it.
std::vector<std::string> SvgWrapped(std::string_view text, double size, double width);

}  // namespace morphograph
