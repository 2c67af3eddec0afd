#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace morphograph {

/// One set of values of a chart.
struct ChartSeries {
  enum class Form { kLine, kPoints, kBars, kBand };
  std::string name;  // in the key; equal names share a colour and one entry of the key
  std::vector<double> x = {}, y = {};
  Form form = Form::kLine;
  std::vector<double> y_low = {};  // kBand: the lower edge, `y` the upper one
  bool dashed = false;
  bool faint = false;  // one of many curves of a kind
};

/// A value to hold the series against, drawn as a line across the chart: a published figure, a limit.
struct ChartMark {
  std::string name;
  double value = 0;
  bool vertical = false;
};

/// A chart with two axes. Axis names carry the unit: "components", "weighted squared error, m²".
struct Chart {
  std::string title;
  std::string x_label, y_label;
  std::string better = {};   // "lower", "higher" or empty: said beside the y axis
  std::string caption = {};  // what is seen, in a sentence or two; under the chart
  std::vector<ChartSeries> series = {};
  std::vector<ChartMark> marks = {};
  bool log_x = false, log_y = false;
  bool y_from_zero = true;
  std::vector<std::string> x_names = {};  // where x = 0, 1, … are kinds of things: their names, in place of numbers
};

/// Values over a grid, as colours, with curves drawn over it (x to the right = columns, y upwards = rows, in cells).
struct HeatMap {
  std::string title;
  std::string x_label, y_label, value_label;
  std::string caption;
  Eigen::MatrixXd values;
  double x_from = 0, x_to = 1, y_from = 0, y_to = 1;  // axis values of the outer edges
  std::vector<ChartSeries> over;                      // in axis values
  bool equal_scales = false;
};

/// The drawing as an SVG element for an HTML page that holds DrawingCss(): no script, nothing to load, text as text. Values that are not
/// finite, and those that are not positive on a log axis, are left out: curves have a gap there. Title and caption are for the page to
/// show; here they are what a screen reader says. Of curves with more points than a screen can show, their outline is drawn.
std::string ChartSvg(const Chart& chart);
std::string HeatMapSvg(const HeatMap& map);

/// Colours and line widths of the drawings, for light and dark pages; they take text and lines from --text, --quiet, --line and --page.
std::string DrawingCss();

}  // namespace morphograph
