#include "api/study/chart_axis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "api/study/markup.h"

namespace morphograph {
namespace {

constexpr double kLargest = 1e150;  // so that differences and their products stay finite

// 1, 2 or 5 times a power of ten, the least that is not below `step`.
double RoundStep(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= step * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

// With as many decimals as tell neighbours apart.
std::string TickText(double value, double step) {
  if (value == 0) return "0";
  const double size = std::abs(value);
  const int decimals = static_cast<int>(std::max(0.0, -std::floor(std::log10(step) + 1e-9)));
  if (size >= 1e6 || decimals > 4) {
    const int digits = 1 + static_cast<int>(std::max(0.0, std::floor(std::log10(size)) - std::floor(std::log10(step) + 1e-9)));
    return ShortNumber(value, std::min(digits, 12));
  }
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::vector<ChartTick> LinearTicks(double from, double to, int count) {
  const double step = RoundStep((to - from) / count);
  std::vector<ChartTick> ticks;
  // By whole numbers of steps: sums of steps would drift.
  const double last = std::floor(to / step + 1e-6);
  for (double i = std::ceil(from / step - 1e-6); i <= last; ++i) ticks.push_back({i * step, TickText(i * step, step)});
  return ticks;
}

}  // namespace

bool ChartAxis::Takes(double value) const { return std::isfinite(value) && std::abs(value) < kLargest && (!log || value > 1 / kLargest); }

double ChartAxis::Place(double value) const {
  if (log) return (std::log10(value) - std::log10(from)) / (std::log10(to) - std::log10(from));
  return (value - from) / (to - from);
}

ChartAxis AxisOver(const std::vector<double>& values, const ChartAxisOptions& options) {
  ChartAxis axis{options.log ? 1.0 : 0.0, options.log ? 10.0 : 1.0, options.log};
  bool any = false;
  for (const double value : values) {
    if (!axis.Takes(value)) continue;
    axis.from = any ? std::min(axis.from, value) : value;
    axis.to = any ? std::max(axis.to, value) : value;
    any = true;
  }
  if (!any) return axis;
  if (options.log) {
    const double low = std::log10(axis.from), high = std::log10(axis.to), range = high > low ? high - low : 1;
    const double single = high > low ? 0 : 0.5;
    axis.from = std::pow(10, low - options.margin_below * range - single);
    axis.to = std::pow(10, high + options.margin_above * range + single);
    return axis;
  }
  if (options.from_zero) {
    axis.from = std::min(axis.from, 0.0);
    axis.to = std::max(axis.to, 0.0);
  }
  if (axis.to - axis.from <= 1e-12 * std::max(std::abs(axis.from), std::abs(axis.to))) {
    const double around = axis.from == 0 ? 0.5 : 0.5 * std::abs(axis.from);
    axis.from -= around;
    axis.to += around;
  }
  const double range = axis.to - axis.from;
  if (!(options.from_zero && axis.from == 0)) axis.from -= options.margin_below * range;
  if (!(options.from_zero && axis.to == 0)) axis.to += options.margin_above * range;
  return axis;
}

std::vector<ChartTick> TicksOf(const ChartAxis& axis, int count) {
  if (!axis.log) return LinearTicks(axis.from, axis.to, count);
  const double low = std::log10(axis.from), high = std::log10(axis.to);
  std::vector<ChartTick> ticks;
  const double apart = std::max(1.0, std::ceil((high - low) / count));  // decades from tick to tick
  if (high - low >= 1) {
    for (double power = std::ceil((low - 1e-9) / apart) * apart; power <= high + 1e-9; power += apart)
      ticks.push_back({std::pow(10, power), ShortNumber(std::pow(10, power), 1)});
  }
  if (ticks.size() >= 3 || (high - low >= 2 && ticks.size() >= 2)) return ticks;
  ticks.clear();
  // Few decades: 1, 2, 5 within each; and within part of one, as on a linear axis.
  for (double power = std::floor(low); power <= high; ++power) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10, power);
      if (axis.Place(value) > -1e-9 && axis.Place(value) < 1 + 1e-9) ticks.push_back({value, ShortNumber(value, 1)});
    }
  }
  if (ticks.size() >= 3) return ticks;
  ticks = LinearTicks(axis.from, axis.to, count);
  std::erase_if(ticks, [&](const ChartTick& tick) { return !axis.Takes(tick.value); });
  return ticks;
}

}  // namespace morphograph
