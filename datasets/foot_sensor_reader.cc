#include "datasets/foot_sensor_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "datasets/errors.h"
#include "datasets/internal/table_text.h"

namespace morphograph {
namespace {

constexpr std::size_t kMostFootColumns = 6 * 500 + 1;
constexpr double kMostFootSamples = 1e9;
constexpr std::array<const char*, 6> kFootTitles = {"acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"};

}  // namespace

bool IsFootSensorText(std::string_view text) {
  TableText table(text, "");
  std::string_view first, second;
  return table.NextLine(&first) && table.NextLine(&second) && first.starts_with("sensor,") && second.starts_with("axis,");
}

SensorRecording ParseFootSensors(std::string_view text, const std::string& file, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) throw std::invalid_argument("ParseFootSensors: the rate must be positive");
  TableText table(text, file);
  std::string_view line;
  if (!table.NextLine(&line) || !line.starts_with("sensor,")) table.Fail(1, "expected sensor,<name>,<name>,…");
  const std::vector<TableCell> titles = CellsOf(line, ',');
  if (titles.size() > kMostFootColumns) table.Fail(1, "more than " + std::to_string(kMostFootColumns) + " columns");
  std::vector<std::string> names;
  std::vector<std::size_t> sensor_of(titles.size());
  for (std::size_t c = 1; c < titles.size(); ++c) {
    const std::string name = table.Name(titles[c]);
    const auto found = std::find(names.begin(), names.end(), name);
    sensor_of[c] = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) names.push_back(name);
  }
  if (!table.NextLine(&line) || !line.starts_with("axis,")) table.Fail(1, "expected axis,acc_x,acc_y,…");
  const std::vector<TableCell> axes = CellsOf(line, ',');
  if (axes.size() != titles.size()) table.Fail(1, "expected " + std::to_string(titles.size()) + " cells, found " + std::to_string(axes.size()));
  // Where each column's value goes: accelerations of all sensors, then rates of all sensors.
  const std::size_t half = 3 * names.size();
  std::vector<std::size_t> place(titles.size());
  std::vector<int> used(2 * half, 0);
  for (std::size_t c = 1; c < axes.size(); ++c) {
    const auto found = std::find(kFootTitles.begin(), kFootTitles.end(), axes[c].text);
    if (found == kFootTitles.end()) table.Fail(axes[c].column, "expected acc_x, acc_y, acc_z, gyr_x, gyr_y or gyr_z");
    const auto value = static_cast<std::size_t>(found - kFootTitles.begin());
    place[c] = value / 3 * half + 3 * sensor_of[c] + value % 3;
    if (used[place[c]]++ > 0) table.Fail(axes[c].column, std::string(axes[c].text) + " of '" + names[sensor_of[c]] + "' stands twice");
  }
  for (std::size_t v = 0; v < half; ++v) {
    if (used[v] == 0) table.Fail(1, "'" + names[v / 3] + "' has no " + kFootTitles[v % 3]);
  }
  std::vector<double> times, values;
  while (table.NextContent(&line)) {
    const std::vector<TableCell> cells = CellsOf(line, ',');
    if (cells.size() != titles.size()) table.Fail(1, "expected " + std::to_string(titles.size()) + " cells, found " + std::to_string(cells.size()));
    const double number = table.Number(cells.front());
    if (std::abs(number) > kMostFootSamples) table.Fail(1, "the sample's number must be within 10^9 of 0");
    times.push_back(number / rate_hz);
    const std::size_t from = values.size();
    values.resize(from + 2 * half, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t c = 1; c < cells.size(); ++c) values[from + place[c]] = table.NumberOrLost(cells[c]);
  }
  if (times.empty()) table.Fail(0, "no sample follows the header");
  const std::vector<std::size_t> rows = RowsInOrder(times);
  SensorRecording recording;
  recording.accelerations.names = names;
  for (const std::size_t row : rows) recording.accelerations.times_s.push_back(times[row]);
  recording.accelerations.values = ColumnsOf(values, 2 * half, rows, 0, half);
  const bool any_rate = std::any_of(used.begin() + static_cast<std::ptrdiff_t>(half), used.end(), [](int n) { return n > 0; });
  recording.rates_rad_s = ColumnsOf(values, 2 * half, rows, half, any_rate ? half : 0);
  recording.orientations.resize(0, recording.accelerations.sample_count());
  return recording;
}

}  // namespace morphograph
