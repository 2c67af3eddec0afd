#include "datasets/readings.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>

#include "datasets/errors.h"
#include "datasets/internal/table_text.h"

namespace morphograph {
namespace {

constexpr std::size_t kMostColumns = 3 * 500 + 1;
constexpr char kAxes[] = "xyz";

std::vector<std::string> NamesOfHeader(const TableText& table, const std::vector<TableCell>& cells) {
  if (cells.size() > kMostColumns) table.Fail(1, "more than " + std::to_string(kMostColumns) + " columns");
  if (cells.front().text != "time") table.Fail(1, "the first column must be \"time\"");
  if (cells.size() < 4 || cells.size() % 3 != 1) {
    table.Fail(1, "expected time,<sensor>.x,<sensor>.y,<sensor>.z and so on: three columns a sensor");
  }
  std::vector<std::string> names;
  std::set<std::string> known;
  for (std::size_t c = 1; c < cells.size(); ++c) {
    const std::string_view title = cells[c].text;
    const char axis = kAxes[(c - 1) % 3];
    if (title.size() < 3 || title[title.size() - 2] != '.' || title.back() != axis) {
      table.Fail(cells[c].column, std::string("expected a column <sensor>.") + axis);
    }
    const std::string name = table.Name({title.substr(0, title.size() - 2), cells[c].column});
    if (axis != 'x') {
      if (name != names.back()) table.Fail(cells[c].column, "expected a column of '" + names.back() + "'");
      continue;
    }
    if (!known.insert(name).second) table.Fail(cells[c].column, "'" + name + "' stands twice in the header");
    names.push_back(name);
  }
  return names;
}

}  // namespace

double Readings::rate_hz() const {
  if (times_s.size() < 2) return 0;
  std::vector<double> steps(times_s.size() - 1);
  for (std::size_t i = 0; i + 1 < times_s.size(); ++i) steps[i] = times_s[i + 1] - times_s[i];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle > 0 ? 1 / *middle : 0;
}

Readings ParseReadingsCsv(std::string_view text, const std::string& file) {
  TableText table(text, file);
  std::string_view line;
  if (!table.NextContent(&line, "#")) throw DatasetError(file, "holds no header");
  const std::vector<std::string> names = NamesOfHeader(table, CellsOf(line, ','));
  std::vector<double> times, values;
  while (table.NextContent(&line, "#")) {
    const std::vector<TableCell> cells = CellsOf(line, ',');
    if (cells.size() != 3 * names.size() + 1) {
      table.Fail(1, "expected " + std::to_string(3 * names.size() + 1) + " cells, found " + std::to_string(cells.size()));
    }
    times.push_back(table.Time(cells.front()));
    for (std::size_t c = 1; c < cells.size(); ++c) values.push_back(table.NumberOrLost(cells[c]));
  }
  if (times.empty()) table.Fail(0, "no sample follows the header");
  return ReadingsInOrder(names, times, values);
}

std::string ReadingsCsv(const Readings& readings) {
  std::string text = "time";
  for (const std::string& name : readings.names) {
    for (const char axis : {'x', 'y', 'z'}) text += "," + name + "." + axis;
  }
  text += '\n';
  char cell[40];
  for (int i = 0; i < readings.sample_count(); ++i) {
    std::snprintf(cell, sizeof cell, "%.6f", readings.times_s[static_cast<std::size_t>(i)]);
    text += cell;
    for (Eigen::Index r = 0; r < readings.values.rows(); ++r) {
      text += ',';
      if (std::isnan(readings.values(r, i))) continue;
      const auto [end, error] = std::to_chars(cell, cell + sizeof cell, readings.values(r, i), std::chars_format::general, 9);
      text.append(cell, end);
    }
    text += '\n';
  }
  return text;
}

}  // namespace morphograph
