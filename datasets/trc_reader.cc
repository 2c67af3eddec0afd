#include "datasets/trc_reader.h"

#include <cmath>
#include <limits>
#include <set>

#include "datasets/errors.h"
#include "datasets/internal/table_text.h"

namespace morphograph {
namespace {

constexpr std::size_t kMostMarkers = 500;

double MetresPerTrcUnit(const TableText& table, const TableCell& cell) {
  if (cell.text == "m" || cell.text == "meters" || cell.text == "metres") return 1;
  if (cell.text == "cm") return 0.01;
  if (cell.text == "mm" || cell.text == "millimeters") return 0.001;
  table.Fail(cell.column, std::string("unit must be m, cm or mm, not '").append(cell.text.substr(0, 20)) + "'");
}

std::vector<TableCell> FilledCells(std::string_view line) {
  std::vector<TableCell> cells = CellsOf(line, '\t');
  std::erase_if(cells, [](const TableCell& cell) { return cell.text.empty(); });
  return cells;
}

// Names stand in the third column and in every third after it.
std::vector<std::string> TrcNames(const TableText& table, std::string_view line) {
  const std::vector<TableCell> cells = CellsOf(line, '\t');
  if (cells.size() < 3 || cells[0].text != "Frame#" || cells[1].text != "Time") table.Fail(1, "expected Frame#, Time and the markers' names, between tabs");
  std::size_t end = cells.size();
  while (end > 2 && cells[end - 1].text.empty()) --end;
  std::vector<std::string> names;
  std::set<std::string> known;
  for (std::size_t c = 2; c < end; ++c) {
    if ((c - 2) % 3 != 0) {
      if (!cells[c].text.empty()) table.Fail(cells[c].column, "expected a name in every third column only");
      continue;
    }
    names.push_back(table.Name(cells[c]));
    if (!known.insert(names.back()).second) table.Fail(cells[c].column, "'" + names.back() + "' stands twice in the header");
    if (names.size() > kMostMarkers) table.Fail(cells[c].column, "more than " + std::to_string(kMostMarkers) + " markers");
  }
  if (names.empty()) table.Fail(1, "names no marker");
  return names;
}

}  // namespace

Readings ParseTrc(std::string_view text, const std::string& file) {
  TableText table(text, file);
  std::string_view line, keys;
  const auto next = [&](const char* what) {
    if (!table.NextLine(&line)) table.Fail(0, std::string("the file ends before ") + what);
  };
  next("the line PathFileType");
  if (!line.starts_with("PathFileType")) table.Fail(1, "a TRC file begins with PathFileType");
  next("the line of keys");
  keys = line;
  next("the line of rates and units");
  // Some writers put more tabs between the settings than between their titles.
  const std::vector<TableCell> titles = FilledCells(keys), settings = FilledCells(line);
  double metres_per_unit = 0;
  for (std::size_t c = 0; c < std::min(titles.size(), settings.size()); ++c) {
    if (titles[c].text == "Units") metres_per_unit = MetresPerTrcUnit(table, settings[c]);
  }
  if (metres_per_unit == 0) table.Fail(0, "the unit is missing");
  next("the names of the markers");
  const std::vector<std::string> names = TrcNames(table, line);
  next("the line X1, Y1, Z1");
  if (!TrimmedText(line).starts_with("X1")) table.Fail(1, "expected the line X1, Y1, Z1 and so on");

  const std::size_t width = 2 + 3 * names.size();
  std::vector<double> times, values;
  while (table.NextContent(&line)) {
    std::vector<TableCell> cells = CellsOf(line, '\t');
    while (cells.size() > width && cells.back().text.empty()) cells.pop_back();
    if (cells.size() != width) table.Fail(1, "expected " + std::to_string(width) + " cells, found " + std::to_string(cells.size()));
    times.push_back(table.Time(cells[1]));
    for (std::size_t m = 0; m < names.size(); ++m) {
      double place[3];
      for (std::size_t axis = 0; axis < 3; ++axis) place[axis] = metres_per_unit * table.NumberOrLost(cells[2 + 3 * m + axis]);
      const bool lost = (place[0] == 0 && place[1] == 0 && place[2] == 0) || std::isnan(place[0] + place[1] + place[2]);
      for (const double value : place) values.push_back(lost ? std::numeric_limits<double>::quiet_NaN() : value);
    }
  }
  if (times.empty()) table.Fail(0, "no frame follows the header");
  return ReadingsInOrder(names, times, values);
}

}  // namespace morphograph
