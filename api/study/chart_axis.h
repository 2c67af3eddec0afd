#pragma once

#include <string>
#include <vector>

namespace morphograph {

/// The range of a chart along one direction, linear or by powers of ten.
struct ChartAxis {
  double from = 0, to = 1;  // from < to; both > 0 on a log axis
  bool log = false;

  /// Whether a value can be drawn at all: finite, and positive on a log axis.
  bool Takes(double value) const;
  /// Where it lies: 0 at `from`, 1 at `to`.
  double Place(double value) const;
};

/// A mark of the axis with its text.
struct ChartTick {
  double value = 0;
  std::string text;
};

struct ChartAxisOptions {
  bool log = false;
  bool from_zero = false;     // a linear range is stretched to hold 0
  double margin_below = 0;    // part of the range that is left free at either end; never beyond a 0 that the range begins or ends with
  double margin_above = 0;
};

/// The range of those of the values that can be drawn; with none of them 0 to 1, or 1 to 10 on a log axis. A single value lies amid its range.
ChartAxis AxisOver(const std::vector<double>& values, const ChartAxisOptions& options);

/// Round values (1, 2 or 5 times a power of ten) over the range, about `count` of them; powers of ten on a log axis of a decade and more.
std::vector<ChartTick> TicksOf(const ChartAxis& axis, int count);

}  // namespace morphograph
