#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "api/study/chart.h"
#include "api/study/chart_frame.h"

namespace morphograph {
namespace {

constexpr int kLevels = 32;          // of colour
constexpr Eigen::Index kMostCells = 120;  // a side; more are averaged
constexpr double kTallest = 420;

// Nine colours of viridis (van der Walt and Smith 2015): lightness grows evenly, for eyes of every kind.
constexpr std::array<std::array<int, 3>, 9> kViridis = {
    {{68, 1, 84}, {71, 44, 122}, {59, 81, 139}, {44, 113, 142}, {33, 144, 141}, {39, 173, 129}, {92, 200, 99}, {170, 220, 50}, {253, 231, 37}}};

std::string ColourOf(int level) {
  const double place = static_cast<double>(level) / (kLevels - 1) * (kViridis.size() - 1);
  const size_t below = std::min<size_t>(static_cast<size_t>(place), kViridis.size() - 2);
  const double part = place - static_cast<double>(below);
  char text[8];
  int mixed[3];
  for (size_t c = 0; c < 3; ++c) mixed[c] = static_cast<int>(std::lround((1 - part) * kViridis[below][c] + part * kViridis[below + 1][c]));
  std::snprintf(text, sizeof text, "#%02x%02x%02x", mixed[0] & 255, mixed[1] & 255, mixed[2] & 255);
  return text;
}

// At most kMostCells a side, each the mean of the finite values that it stands for.
Eigen::MatrixXd Coarse(const Eigen::MatrixXd& values) {
  const Eigen::Index rows = std::min(values.rows(), kMostCells), cols = std::min(values.cols(), kMostCells);
  if (rows == values.rows() && cols == values.cols()) return values;
  Eigen::MatrixXd coarse(rows, cols);
  for (Eigen::Index c = 0; c < cols; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) {
      double sum = 0;
      int count = 0;
      for (Eigen::Index i = r * values.rows() / rows; i < (r + 1) * values.rows() / rows; ++i) {
        for (Eigen::Index j = c * values.cols() / cols; j < (c + 1) * values.cols() / cols; ++j) {
          if (std::isfinite(values(i, j))) sum += values(i, j), ++count;
        }
      }
      coarse(r, c) = count > 0 ? sum / count : NAN;
    }
  }
  return coarse;
}

// Neighbours of one colour in a row become one rectangle; all of one colour become one path.
std::string CellsSvg(const PlotArea& area, const Eigen::MatrixXd& values, const ChartAxis& scale) {
  std::array<SvgPath, kLevels> paths;
  const double width = area.width / static_cast<double>(values.cols()), height = area.height / static_cast<double>(values.rows());
  const auto level_of = [&](double value) {
    return scale.Takes(value) ? std::clamp(static_cast<int>(kLevels * scale.Place(value)), 0, kLevels - 1) : -1;
  };
  for (Eigen::Index r = 0; r < values.rows(); ++r) {
    for (Eigen::Index c = 0; c < values.cols();) {
      const int level = level_of(values(r, c));
      Eigen::Index end = c + 1;
      while (end < values.cols() && level_of(values(r, end)) == level) ++end;
      if (level >= 0) {
        paths[static_cast<size_t>(level)].Rectangle(area.left + static_cast<double>(c) * width,
                                                    area.top + area.height - static_cast<double>(r + 1) * height,
                                                    static_cast<double>(end - c) * width, height);
      }
      c = end;
    }
  }
  std::string svg = "<g class=\"cells\">";
  for (int level = 0; level < kLevels; ++level) {
    const SvgPath& path = paths[static_cast<size_t>(level)];
    if (!path.is_empty()) svg += "<path fill=\"" + ColourOf(level) + "\" d=\"" + path.data() + "\"/>";
  }
  return svg + "</g>";
}

// The colours and what they stand for, right of the map.
std::string ScaleSvg(const ChartAxis& scale, const PlotArea& area) {
  const double x = area.left + area.width + 16;
  std::string svg = "<g class=\"cells\">";
  for (int level = 0; level < kLevels; ++level) {
    SvgPath path;
    path.Rectangle(x, area.top + area.height * (kLevels - 1 - level) / kLevels, 12, area.height / kLevels + 0.5);
    svg += "<path fill=\"" + ColourOf(level) + "\" d=\"" + path.data() + "\"/>";
  }
  svg += "</g>";
  for (const ChartTick& tick : TicksOf(scale, 5)) {
    svg += SvgText(x + 16, area.top + area.height * (1 - scale.Place(tick.value)) + 4, tick.text, SvgAnchor::kStart, "quiet");
  }
  return svg;
}

}  // namespace

std::string HeatMapSvg(const HeatMap& map) {
  const Eigen::MatrixXd values = Coarse(map.values);
  const ChartAxis scale = AxisOver({values.data(), values.data() + values.size()}, {});
  const SeriesColours colours(map.over);
  PlotArea area;
  const auto range = [](double from, double to) {
    const bool usable = std::isfinite(from) && std::isfinite(to) && from < to;
    return usable ? ChartAxis{from, to} : ChartAxis{};
  };
  area.x = range(map.x_from, map.x_to);
  area.y = range(map.y_from, map.y_to);
  double after_key = 0, after_label = 0;
  std::string parts = KeySvg(map.over, colours, 0, &after_key);
  if (!map.value_label.empty()) {
    parts += SvgText(kDrawingWidth - 4, after_key + 12, "colour: " + map.value_label, SvgAnchor::kEnd, "quiet");
    after_key += 17;
  }
  parts += YLabelSvg(map.y_label, "", after_key, &after_label);
  const std::vector<ChartTick> y_ticks = TicksOf(area.y, 6);
  double widest = 0;
  for (const ChartTick& tick : y_ticks) widest = std::max(widest, SvgTextWidth(tick.text, kTextSize));
  area.left = widest + 12;
  area.top = after_label + 4;
  area.width = kDrawingWidth - area.left - 70;
  area.height = 300;
  if (map.equal_scales) {
    const double ratio = (area.y.to - area.y.from) / (area.x.to - area.x.from);
    area.height = std::clamp(area.width * ratio, 60.0, kTallest);
    area.width = area.height / ratio < area.width ? area.height / ratio : area.width;
  }
  if (values.size() > 0) parts += CellsSvg(area, values, scale) + ScaleSvg(scale, area);
  const std::vector<ChartTick> x_ticks = TicksOf(area.x, std::max(2, static_cast<int>(area.width / 60)));
  parts += AxesSvg(area, x_ticks, {}, map.x_label);
  for (const ChartTick& tick : y_ticks) parts += SvgText(area.left - 6, area.Y(tick.value) + 4, tick.text, SvgAnchor::kEnd, "quiet");
  for (const ChartSeries& series : map.over)
    parts += SeriesSvg(area, series, "casing") + SeriesSvg(area, series, colours.ClassOf(series.name));  // seen on every colour
  if (values.size() == 0)
    parts += SvgText(area.left + area.width / 2, area.top + area.height / 2, "no data", SvgAnchor::kMiddle, "quiet");
  const std::string description = map.caption + (map.caption.empty() ? "" : " ") + "Across: " + map.x_label + ". Upwards: " + map.y_label +
                                  ". Colour: " + map.value_label + ".";
  return SvgElement(area.top + area.height + RoomBelow(x_ticks, area.width / 2, map.x_label), map.title, description, parts);
}

}  // namespace morphograph
