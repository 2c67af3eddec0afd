#include "api/study/chart.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "api/study/chart_frame.h"

namespace morphograph {
namespace {

constexpr double kPlotHeight = 230;

// Bars of several series stand side by side at each x.
struct BarLayout {
  std::vector<const ChartSeries*> series;
  double apart = 1;  // smallest distance of two x
  double filled = 0.8;  // part of it that the bars take
};

BarLayout LayOutBars(const Chart& chart) {
  BarLayout bars;
  std::set<double> places;
  for (const ChartSeries& series : chart.series) {
    if (series.form != ChartSeries::Form::kBars) continue;
    bars.series.push_back(&series);
    for (const double x : series.x)
      if (std::isfinite(x)) places.insert(x);
  }
  if (places.size() > 1) {
    bars.apart = *places.rbegin() - *places.begin();
    for (auto place = std::next(places.begin()); place != places.end(); ++place) bars.apart = std::min(bars.apart, *place - *std::prev(place));
  }
  // Of a histogram the bars nearly touch.
  if (bars.series.size() == 1 && chart.x_names.empty()) bars.filled = 0.94;
  return bars;
}

std::string BarsSvg(const PlotArea& area, const BarLayout& bars, const SeriesColours& colours) {
  std::string svg;
  const double width = bars.filled * bars.apart / static_cast<double>(bars.series.size());
  const double floor_y = area.Y(area.y.log ? area.y.from : std::clamp(0.0, area.y.from, area.y.to));
  for (size_t s = 0; s < bars.series.size(); ++s) {
    const ChartSeries& series = *bars.series[s];
    SvgPath path;
    for (size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!area.Takes(series.x[i], series.y[i])) continue;
      const double from = series.x[i] - bars.filled * bars.apart / 2 + static_cast<double>(s) * width;
      if (!area.x.Takes(from) || !area.x.Takes(from + width)) continue;
      const double x = area.X(from), y = area.Y(series.y[i]);
      const double gap = bars.series.size() > 1 ? 1 : 0;  // so that neighbours of one height stay apart
      path.Rectangle(x, std::min(y, floor_y), std::max(0.5, area.X(from + width) - x - gap), std::max(0.5, std::abs(floor_y - y)));
    }
    svg += SvgPathElement(path, "b " + colours.ClassOf(series.name));
  }
  return svg;
}

// Dashed lines with their names, names of near lines one over the other.
std::string MarksSvg(const PlotArea& area, const std::vector<ChartMark>& marks) {
  std::vector<const ChartMark*> across, upright;
  for (const ChartMark& mark : marks) {
    if ((mark.vertical ? area.x : area.y).Takes(mark.value)) (mark.vertical ? upright : across).push_back(&mark);
  }
  const auto by_value = [](const ChartMark* a, const ChartMark* b) { return a->value < b->value; };
  std::stable_sort(across.begin(), across.end(), by_value);
  std::stable_sort(upright.begin(), upright.end(), by_value);
  std::string lines, names;
  double lowest_free = area.top + area.height;  // names go upwards from here
  for (const ChartMark* mark : across) {
    const double y = area.Y(mark->value);
    lines += SvgLine(area.left, y, area.left + area.width, y, "mark");
    const double text_y = std::max(area.top + 10, std::min(y - 4, lowest_free));
    names += SvgText(area.left + area.width - 2, text_y, mark->name, SvgAnchor::kEnd, "halo");
    lowest_free = text_y - 14;
  }
  double next_y = area.top + 11, last_end = -1;
  for (const ChartMark* mark : upright) {
    const double x = area.X(mark->value), width = SvgTextWidth(mark->name, kTextSize);
    lines += SvgLine(x, area.top, x, area.top + area.height, "mark");
    const bool to_left = x + width + 6 > area.left + area.width;
    const double start = to_left ? x - 4 - width : x + 4;
    next_y = start < last_end ? next_y + 14 : area.top + 11;
    names += SvgText(to_left ? x - 4 : x + 4, next_y, mark->name, to_left ? SvgAnchor::kEnd : SvgAnchor::kStart, "halo");
    last_end = std::max(last_end, start + width + 4);
  }
  return lines + names;
}

std::string Description(const Chart& chart, const SeriesColours& colours) {
  std::string text = chart.caption + (chart.caption.empty() ? "" : " ") + "Across: " + chart.x_label + ". Upwards: " + chart.y_label + ".";
  for (const std::string& name : colours.names()) text += (&name == &colours.names().front() ? " Shown: " : ", ") + name;
  return text;
}

}  // namespace

std::string ChartSvg(const Chart& chart) {
  const SeriesColours colours(chart.series);
  const BarLayout bars = LayOutBars(chart);
  PlotArea area;
  std::vector<double> xs, ys;
  bool has_points = false;
  const ChartAxis any_x{0, 1, chart.log_x}, any_y{0, 1, chart.log_y};
  for (const ChartSeries& series : chart.series) {
    for (size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!any_x.Takes(series.x[i]) || !any_y.Takes(series.y[i])) continue;
      const double half = series.form == ChartSeries::Form::kBars ? bars.apart / 2 : 0;
      xs.insert(xs.end(), {series.x[i] - half, series.x[i] + half});
      ys.push_back(series.y[i]);
      if (series.form == ChartSeries::Form::kBand && i < series.y_low.size()) ys.push_back(series.y_low[i]);
    }
    has_points |= series.form == ChartSeries::Form::kPoints;
  }
  const bool is_empty = xs.empty();
  for (const ChartMark& mark : chart.marks) (mark.vertical ? xs : ys).push_back(mark.value);
  for (size_t i = 0; i < chart.x_names.size(); ++i) xs.insert(xs.end(), {static_cast<double>(i) - 0.5, static_cast<double>(i) + 0.5});
  const double at_sides = has_points && bars.series.empty() ? 0.02 : 0;
  area.x = AxisOver(xs, {.log = chart.log_x, .margin_below = at_sides, .margin_above = at_sides});
  area.y = AxisOver(ys, {.log = chart.log_y, .from_zero = chart.y_from_zero || !bars.series.empty(), .margin_below = 0.05, .margin_above = 0.06});

  const std::vector<ChartTick> y_ticks = TicksOf(area.y, 5);
  double widest = 0;
  for (const ChartTick& tick : y_ticks) widest = std::max(widest, SvgTextWidth(tick.text, kTextSize));
  double after_key = 0, after_label = 0;
  std::string parts = KeySvg(chart.series, colours, 0, &after_key);
  parts += YLabelSvg(chart.y_label, chart.better, after_key, &after_label);
  std::vector<ChartTick> x_ticks;
  for (size_t i = 0; i < chart.x_names.size(); ++i) x_ticks.push_back({static_cast<double>(i), chart.x_names[i]});
  if (chart.x_names.empty()) x_ticks = TicksOf(area.x, 7);
  const auto apart = [&] {
    return x_ticks.size() > 1 ? area.width * (area.x.Place(x_ticks[1].value) - area.x.Place(x_ticks[0].value)) : area.width;
  };
  area.left = widest + 12;
  area.top = after_label + 4;
  area.width = kDrawingWidth - area.left - 14;
  area.height = kPlotHeight;
  if (!x_ticks.empty()) {
    area.left = std::max(area.left, RoomLeftOf(x_ticks, apart()) - area.width * area.x.Place(x_ticks[0].value));
    area.width = kDrawingWidth - area.left - 14;
  }

  parts += AxesSvg(area, x_ticks, y_ticks, chart.x_label);
  // Wide and faint things first, what they must not hide last.
  for (const ChartSeries& series : chart.series)
    if (series.form == ChartSeries::Form::kBand) parts += SeriesSvg(area, series, colours.ClassOf(series.name));
  if (!bars.series.empty()) parts += BarsSvg(area, bars, colours);
  for (const bool faint : {true, false}) {
    for (const ChartSeries& series : chart.series) {
      const bool drawn = series.form == ChartSeries::Form::kLine || series.form == ChartSeries::Form::kPoints;
      if (drawn && series.faint == faint) parts += SeriesSvg(area, series, colours.ClassOf(series.name));
    }
  }
  parts += MarksSvg(area, chart.marks);
  if (is_empty)
    parts += SvgText(area.left + area.width / 2, area.top + area.height / 2, "no data", SvgAnchor::kMiddle, "quiet");
  return SvgElement(area.top + area.height + RoomBelow(x_ticks, apart(), chart.x_label), chart.title, Description(chart, colours), parts);
}

}  // namespace morphograph
