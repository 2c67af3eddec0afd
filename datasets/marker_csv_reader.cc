#include "datasets/marker_csv_reader.h"

#include <cmath>
#include <set>
#include <stdexcept>

#include "datasets/errors.h"
#include "datasets/internal/table_text.h"

namespace morphograph {
namespace {

constexpr std::size_t kMostTableColumns = 3 * 500 + 1;
constexpr double kMostTableFrames = 1e9;
constexpr std::string_view kAxisNames[] = {"x", "y", "z"};

bool HasTwoHeaderRows(std::string_view first, std::string_view second) { return first.starts_with(",") && second.starts_with(",x,y,z"); }

bool HasOneHeaderRow(std::string_view first) {
  const std::vector<TableCell> cells = CellsOf(first.substr(0, 200), ',');
  return cells.size() > 3 && (cells[0].text == "frame" || cells[0].text == "Frame") && cells[1].text.ends_with("_x") && cells[2].text.ends_with("_y");
}

}  // namespace

bool IsMarkerTable(std::string_view text) {
  TableText table(text, "");
  std::string_view first, second;
  return table.NextLine(&first) && table.NextLine(&second) && (HasOneHeaderRow(first) || HasTwoHeaderRows(first, second));
}

Readings ParseMarkerTable(std::string_view text, const std::string& file, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) throw std::invalid_argument("ParseMarkerTable: the rate must be positive");
  TableText table(text, file);
  std::string_view line;
  if (!table.NextLine(&line)) table.Fail(0, "holds no header");
  std::vector<TableCell> titles = CellsOf(line, ','), axes;
  if (titles.size() > kMostTableColumns) table.Fail(1, "more than " + std::to_string(kMostTableColumns) + " columns");
  if (titles.size() < 4 || titles.size() % 3 != 1) table.Fail(1, "expected a frame's number and three columns a marker");
  if (titles.front().text.empty()) {
    if (!table.NextLine(&line)) table.Fail(0, "the row of axes is missing");
    axes = CellsOf(line, ',');
    if (axes.size() != titles.size()) table.Fail(1, "expected " + std::to_string(titles.size()) + " cells, found " + std::to_string(axes.size()));
  } else {
    axes = titles;
    for (std::size_t c = 1; c < titles.size(); ++c) {
      const std::size_t at = titles[c].text.rfind('_');
      if (at == std::string_view::npos) table.Fail(titles[c].column, "expected a column <marker>_x, <marker>_y or <marker>_z");
      axes[c].text = titles[c].text.substr(at + 1);
      titles[c].text = titles[c].text.substr(0, at);
    }
  }
  std::vector<std::string> names;
  std::set<std::string> known;
  for (std::size_t c = 1; c < titles.size(); ++c) {
    const std::string name = table.Name(titles[c]);
    if (axes[c].text != kAxisNames[(c - 1) % 3]) table.Fail(axes[c].column, std::string("expected the column of ").append(kAxisNames[(c - 1) % 3]));
    if (c % 3 == 1) {
      if (!known.insert(name).second) table.Fail(titles[c].column, "'" + name + "' stands twice in the header");
      names.push_back(name);
    } else if (name != names.back()) {
      table.Fail(titles[c].column, "expected a column of '" + names.back() + "'");
    }
  }
  std::vector<double> times, values;
  while (table.NextContent(&line)) {
    const std::vector<TableCell> cells = CellsOf(line, ',');
    if (cells.size() != titles.size()) table.Fail(1, "expected " + std::to_string(titles.size()) + " cells, found " + std::to_string(cells.size()));
    const double frame = table.Number(cells.front());
    if (std::abs(frame) > kMostTableFrames) table.Fail(1, "the frame's number must be within 10^9 of 0");
    times.push_back(frame / rate_hz);
    for (std::size_t c = 1; c < cells.size(); ++c) values.push_back(table.NumberOrLost(cells[c]));
  }
  if (times.empty()) table.Fail(0, "no frame follows the header");
  return ReadingsInOrder(names, times, values);
}

}  // namespace morphograph
