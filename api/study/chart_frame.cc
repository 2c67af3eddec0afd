#include "api/study/chart_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "api/study/markup.h"

namespace morphograph {
namespace {

constexpr int kColours = 8;
constexpr double kRow = 17;
constexpr size_t kMostPoints = 3000;

// Grows the outline of the values in each pixel column, so that the curve looks as if all of its points were drawn.
void AddOutline(const PlotArea& area, const std::vector<std::pair<double, double>>& points, SvgPath* path) {
  struct Column {
    double first, last, low, high;
  };
  bool started = false;
  for (size_t i = 0; i < points.size();) {
    const double column = std::floor(points[i].first);
    Column of{points[i].second, 0, points[i].second, points[i].second};
    for (; i < points.size() && std::floor(points[i].first) == column; ++i) {
      of.last = points[i].second;
      of.low = std::min(of.low, of.last);
      of.high = std::max(of.high, of.last);
    }
    const double x = std::min(column + 0.5, area.left + area.width);
    if (!started) path->MoveTo(x, of.first);
    started = true;
    path->LineTo(x, of.first);
    path->LineTo(x, of.low);
    path->LineTo(x, of.high);
    path->LineTo(x, of.last);
  }
}

// One unbroken stretch of a curve, in units of the drawing.
void AddRun(const PlotArea& area, const std::vector<std::pair<double, double>>& run, SvgPath* path) {
  if (run.empty()) return;
  const bool forward = std::is_sorted(run.begin(), run.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (forward && static_cast<double>(run.size()) > 3 * area.width) return AddOutline(area, run, path);
  path->MoveTo(run.front().first, run.front().second);
  auto [last_x, last_y] = run.front();
  for (size_t i = 1; i < run.size(); ++i) {
    const auto [x, y] = run[i];
    // A turn smaller than half a pixel is not seen.
    if (i + 1 < run.size() && std::hypot(x - last_x, y - last_y) < 0.5) continue;
    path->LineTo(x, y);
    last_x = x, last_y = y;
  }
  if (run.size() == 1) path->Dot(run.front().first, run.front().second);
}

constexpr double kSlant_deg = -35, kSlantSine = 0.574, kSlantCosine = 0.819;

double WidestOf(const std::vector<ChartTick>& ticks) {
  double widest = 0;
  for (const ChartTick& tick : ticks) widest = std::max(widest, SvgTextWidth(tick.text, kTextSize));
  return widest;
}

bool IsSlanted(const std::vector<ChartTick>& ticks, double apart) { return ticks.size() > 1 && WidestOf(ticks) + 8 > apart; }

double TickRoom(const std::vector<ChartTick>& ticks, double apart) {
  return IsSlanted(ticks, apart) ? 14 + kSlantSine * WidestOf(ticks) : 20;
}

double SampleWidth(const ChartSeries& series) {
  return series.form == ChartSeries::Form::kLine ? 24 : 15;
}

std::string Sample(const ChartSeries& series, const std::string& colour, double x, double y) {
  SvgPath path;
  switch (series.form) {
    case ChartSeries::Form::kLine:
      path.MoveTo(x, y);
      path.LineTo(x + 18, y);
      return SvgPathElement(path, "l " + colour + (series.dashed ? " dash" : ""));
    case ChartSeries::Form::kPoints:
      path.Dot(x + 5, y);
      return SvgPathElement(path, "p " + colour);
    default:
      path.Rectangle(x, y - 5, 10, 10);
      return SvgPathElement(path, (series.form == ChartSeries::Form::kBand ? "a " : "b ") + colour);
  }
}

}  // namespace

SeriesColours::SeriesColours(const std::vector<ChartSeries>& series) {
  for (const ChartSeries& one : series) {
    if (!one.name.empty() && std::find(names_.begin(), names_.end(), one.name) == names_.end()) names_.push_back(one.name);
  }
}

std::string SeriesColours::ClassOf(const std::string& name) const {
  const auto place = std::find(names_.begin(), names_.end(), name);
  if (name.empty() || place == names_.end()) return "kn";
  return {'k', static_cast<char>('0' + (place - names_.begin()) % kColours)};
}

std::string KeySvg(const std::vector<ChartSeries>& series, const SeriesColours& colours, double top, double* bottom) {
  std::string svg;
  double x = 4, y = top;
  for (const std::string& name : colours.names()) {
    // A curve says more of its look than the band around it.
    const auto of_name = [&](const ChartSeries& one) { return one.name == name; };
    const auto line = [&](const ChartSeries& one) { return one.name == name && one.form == ChartSeries::Form::kLine; };
    auto shown = std::find_if(series.begin(), series.end(), line);
    if (shown == series.end()) shown = std::find_if(series.begin(), series.end(), of_name);
    const double width = SampleWidth(*shown) + SvgTextWidth(name, kTextSize) + 16;
    if (x > 4 && x + width > kDrawingWidth) x = 4, y += kRow;
    svg += Sample(*shown, colours.ClassOf(name), x, y + 8) + SvgText(x + SampleWidth(*shown), y + 12, name);
    x += width;
  }
  *bottom = colours.names().empty() ? top : y + kRow;
  return svg;
}

std::string YLabelSvg(const std::string& label, const std::string& better, double top, double* bottom) {
  std::string svg;
  double y = top;
  const std::string arrow = better == "lower" ? "↓ " : better == "higher" ? "↑ " : "";
  const std::string word = better.empty() ? "" : arrow + better + " is better";
  std::vector<std::string> lines = SvgWrapped(label, kTextSize, kDrawingWidth - 8);
  // At the end of the last line where it fits.
  const double used = lines.empty() ? 0 : SvgTextWidth(lines.back(), kTextSize);
  const bool own_line = !word.empty() && used + SvgTextWidth(word, kTextSize) + 20 > kDrawingWidth - 8;
  for (const std::string& line : lines) {
    svg += SvgText(4, y + 12, line, SvgAnchor::kStart, "name");
    y += 15;
  }
  if (!word.empty()) {
    if (own_line || lines.empty()) y += 15;
    svg += SvgText(kDrawingWidth - 4, y - 3, word, SvgAnchor::kEnd, "quiet");
  }
  *bottom = y + 4;
  return svg;
}

double RoomLeftOf(const std::vector<ChartTick>& x_ticks, double apart) {
  return IsSlanted(x_ticks, apart) ? kSlantCosine * SvgTextWidth(x_ticks.front().text, kTextSize) + 4 : 0;
}

double RoomBelow(const std::vector<ChartTick>& x_ticks, double apart, const std::string& x_label) {
  return TickRoom(x_ticks, apart) + 15 * static_cast<double>(SvgWrapped(x_label, kTextSize, kDrawingWidth - 8).size()) + 4;
}

std::string AxesSvg(const PlotArea& area, const std::vector<ChartTick>& x_ticks, const std::vector<ChartTick>& y_ticks,
                    const std::string& x_label) {
  std::string svg;
  const double right = area.left + area.width, bottom = area.top + area.height;
  SvgPath grid, axis;
  for (const ChartTick& tick : y_ticks) {
    const double y = area.Y(tick.value);
    grid.MoveTo(area.left, y);
    grid.LineTo(right, y);
    svg += SvgText(area.left - 6, y + 4, tick.text, SvgAnchor::kEnd, "quiet");
  }
  const double apart = x_ticks.size() > 1 ? area.X(x_ticks[1].value) - area.X(x_ticks[0].value) : area.width;
  const bool slanted = IsSlanted(x_ticks, apart);
  for (const ChartTick& tick : x_ticks) {
    const double x = area.X(tick.value);
    axis.MoveTo(x, bottom);
    axis.LineTo(x, bottom + 4);
    svg += slanted ? SvgText(x + 3, bottom + 14, tick.text, SvgAnchor::kEnd, "quiet", kSlant_deg)
                   : SvgText(x, bottom + 16, tick.text, SvgAnchor::kMiddle, "quiet");
  }
  axis.MoveTo(area.left, bottom);
  axis.LineTo(right, bottom);
  if (!y_ticks.empty() && !area.y.log && area.y.from < 0 && area.y.to > 0) {
    axis.MoveTo(area.left, area.Y(0));
    axis.LineTo(right, area.Y(0));
  }
  double y = bottom + TickRoom(x_ticks, apart) + 12;
  for (const std::string& line : SvgWrapped(x_label, kTextSize, kDrawingWidth - 8)) {
    svg += SvgText(std::min(area.left + area.width / 2, kDrawingWidth / 2 + 20), y, line, SvgAnchor::kMiddle, "name");
    y += 15;
  }
  return SvgPathElement(grid, "grid") + SvgPathElement(axis, "axis") + svg;
}

std::string SeriesSvg(const PlotArea& area, const ChartSeries& series, const std::string& colour) {
  const size_t count = std::min(series.x.size(), series.y.size());
  const std::string faint = series.faint ? " faint" : "";
  SvgPath path;
  if (series.form == ChartSeries::Form::kPoints) {
    std::set<std::pair<int, int>> drawn;  // in halves of a unit: more on one spot add nothing
    const size_t stride = (count + kMostPoints - 1) / kMostPoints;
    for (size_t i = 0; i < count; i += std::max<size_t>(1, stride)) {
      if (!area.Takes(series.x[i], series.y[i])) continue;
      const double x = area.X(series.x[i]), y = area.Y(series.y[i]);
      if (drawn.insert({static_cast<int>(2 * x), static_cast<int>(2 * y)}).second) path.Dot(x, y);
    }
    return SvgPathElement(path, "p " + colour + faint);
  }
  if (series.form == ChartSeries::Form::kBand) {
    const size_t edges = std::min(count, series.y_low.size());
    for (size_t from = 0; from < edges;) {
      size_t to = from;
      while (to < edges && area.Takes(series.x[to], series.y[to]) && area.Takes(series.x[to], series.y_low[to])) ++to;
      for (size_t i = from; i < to; ++i) {
        const double x = area.X(series.x[i]), y = area.Y(series.y[i]);
        i == from ? path.MoveTo(x, y) : path.LineTo(x, y);
      }
      for (size_t i = to; i > from; --i) path.LineTo(area.X(series.x[i - 1]), area.Y(series.y_low[i - 1]));
      if (to > from) path.Close();
      from = to + 1;
    }
    return SvgPathElement(path, "a " + colour + faint);
  }
  std::vector<std::pair<double, double>> run;
  for (size_t i = 0; i <= count; ++i) {
    if (i < count && area.Takes(series.x[i], series.y[i])) {
      run.emplace_back(area.X(series.x[i]), area.Y(series.y[i]));
    } else {
      AddRun(area, run, &path);
      run.clear();
    }
  }
  return SvgPathElement(path, "l " + colour + (series.dashed ? " dash" : "") + faint);
}

std::string SvgElement(double height, const std::string& title, const std::string& description, const std::string& parts) {
  return "<svg class=\"drawing\" role=\"img\" viewBox=\"0 0 " + SvgNumber(kDrawingWidth) + " " + SvgNumber(height) +
         "\" xmlns=\"http://www.w3.org/2000/svg\"><title>" + Escaped(title) + "</title><desc>" + Escaped(description) + "</desc>" + parts +
         "</svg>";
}

std::string DrawingCss() {
  // After Okabe and Ito, whose colours those tell apart who see colours otherwise; darker or lighter as the page asks.
  return R"css(
.drawing { display: block; width: 100%; height: auto; overflow: visible; }
.drawing text { font: 12px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif; fill: var(--text); }
.drawing .quiet { fill: var(--quiet); }
.drawing .name { font-weight: 600; }
.drawing .grid { stroke: var(--line); stroke-width: 1; fill: none; }
.drawing .axis { stroke: var(--quiet); stroke-width: 1; fill: none; }
.drawing .l { stroke: currentColor; stroke-width: 2; fill: none; stroke-linejoin: round; stroke-linecap: round; }
.drawing .dash { stroke-dasharray: 6 4; stroke-linecap: butt; }
.drawing .p { stroke: currentColor; stroke-width: 5; fill: none; stroke-linecap: round; stroke-opacity: .75; }
.drawing .b { fill: currentColor; }
.drawing .a { fill: currentColor; fill-opacity: .22; }
.drawing .l.faint { stroke-width: 1; stroke-opacity: .35; }
.drawing .p.faint { stroke-width: 3; stroke-opacity: .3; }
.drawing .a.faint { fill-opacity: .1; }
.drawing .l.casing { stroke: #fff; stroke-width: 5; stroke-opacity: .85; }
.drawing .p.casing { stroke: #fff; stroke-width: 7; }
.drawing .mark { stroke: var(--text); stroke-width: 1.25; stroke-dasharray: 2 3; fill: none; }
.drawing .halo { paint-order: stroke; stroke: var(--page); stroke-width: 4px; stroke-linejoin: round; }
.drawing .cells { shape-rendering: crispEdges; }
.k0 { color: #0068a8; } .k1 { color: #c94f00; } .k2 { color: #00805c; } .k3 { color: #a8508a; }
.k4 { color: #a87400; } .k5 { color: #2f8fc4; } .k6 { color: #6d5bd0; } .k7 { color: #5a5f66; } .kn { color: #80858c; }
@media (prefers-color-scheme: dark) {
  .k0 { color: #4fa8e8; } .k1 { color: #ff8c42; } .k2 { color: #35c79a; } .k3 { color: #e49bca; }
  .k4 { color: #efb93c; } .k5 { color: #9ad4f7; } .k6 { color: #ab9df5; } .k7 { color: #b9bfc7; } .kn { color: #8d939b; } }
)css";
}

}  // namespace morphograph
