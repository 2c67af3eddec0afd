#pragma once

#include <string>
#include <vector>

#include "api/study/chart.h"
#include "api/study/chart_axis.h"
#include "api/study/svg_writer.h"

namespace morphograph {

inline constexpr double kDrawingWidth = 520;  // units of the drawing; about pixels on the page
inline constexpr double kTextSize = 12;

/// Where the values of a drawing go: the area between its axes, y downwards as in SVG.
struct PlotArea {
  double left = 0, top = 0, width = 0, height = 0;
  ChartAxis x, y;

  double X(double value) const { return left + width * x.Place(value); }
  double Y(double value) const { return top + height * (1 - y.Place(value)); }
  bool Takes(double x_value, double y_value) const { return x.Takes(x_value) && y.Takes(y_value); }
};

/// Colours by the names of series, in order of appearance; unnamed series are grey.
class SeriesColours {
 public:
  explicit SeriesColours(const std::vector<ChartSeries>& series);
  /// Class of the colour, "k0", "k1", …, or "kn".
  std::string ClassOf(const std::string& name) const;
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::vector<std::string> names_;
};

/// The key, a row or more from `top` on. @param bottom  set to where it ends.
std::string KeySvg(const std::vector<ChartSeries>& series, const SeriesColours& colours, double top, double* bottom);

/// The label of the y axis over the plot and, where one way is better, which. @param bottom  set to where it ends.
std::string YLabelSvg(const std::string& label, const std::string& better, double top, double* bottom);

/// Grid, ticks and the label of the x axis; names at the x ticks that are too long to stand side by side are slanted.
std::string AxesSvg(const PlotArea& area, const std::vector<ChartTick>& x_ticks, const std::vector<ChartTick>& y_ticks,
                    const std::string& x_label);
/// Room that the x ticks and the label need below the plot. @param apart  between two ticks, in units of the drawing.
double RoomBelow(const std::vector<ChartTick>& x_ticks, double apart, const std::string& x_label);
/// Room that the first slanted name needs left of its tick; 0 where names stand upright.
double RoomLeftOf(const std::vector<ChartTick>& x_ticks, double apart);

/// Lines, points and bands; bars are the chart's own.
std::string SeriesSvg(const PlotArea& area, const ChartSeries& series, const std::string& colour);

/// The whole element around its parts, with a title and a description for those who do not see it.
std::string SvgElement(double height, const std::string& title, const std::string& description, const std::string& parts);

}  // namespace morphograph
