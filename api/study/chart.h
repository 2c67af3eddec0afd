#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace morphograph {

/// One set of values of a chart.
struct ChartSeries {
  enum class Form { kLine, kPoints, kBars, kBand };
  std::string name;  // in the key; equal names share a colour and one entry of the key
  std::vector<double> x, y;
  Form form = Form::kLine;
  std::vector<double> y_low;  // kBand: the lower edge, `y` the upper one
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
  std::string better;   // "lower", "higher" or empty: said beside the y axis
  std::string caption;  // what is seen, in a sentence or two; under the chart
  std::vector<ChartSeries> series;
  std::vector<ChartMark> marks;
  bool log_x = false, log_y = false;
  bool y_from_zero = true;
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

/// The drawing as a self-contained SVG element for an HTML page: no script, text as text. Values that are not finite are left out.
std::string ChartSvg(const Chart& chart);
std::string HeatMapSvg(const HeatMap& map);

}  // namespace morphograph
