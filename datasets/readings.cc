#include "datasets/readings.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <set>

#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

constexpr std::size_t kMostColumns = 3 * 500 + 1;
constexpr double kLongestTime_s = 1e10;  // times since 1970 are 1.8e9 s; milliseconds would be 1.8e12
constexpr double kLargestValue = 1e30;   // squares of it are still finite
constexpr char kAxes[] = "xyz";

std::string_view Trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

bool IsNan(std::string_view text) {
  if (text.size() != 3) return false;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return lower(text[0]) == 'n' && lower(text[1]) == 'a' && lower(text[2]) == 'n';
}

struct Cell {
  std::string_view text;
  int column = 0;  // of its first character, from 1
};

std::vector<Cell> CellsOf(std::string_view line) {
  std::vector<Cell> cells;
  for (std::size_t from = 0;;) {
    const std::size_t comma = line.find(',', from);
    const std::size_t to = std::min(comma, line.size());
    cells.push_back({Trimmed(line.substr(from, to - from)), static_cast<int>(from) + 1});
    if (comma == std::string_view::npos) return cells;
    from = comma + 1;
  }
}

class CsvReader {
 public:
  CsvReader(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  }

  Readings Read() {
    std::string_view line;
    if (!NextLine(&line)) throw DatasetError(file_, "holds no header");
    ReadHeader(CellsOf(line));
    while (NextLine(&line)) ReadRow(CellsOf(line));
    if (times_.empty()) throw DatasetError(file_, line_, 0, "no sample follows the header");
    return InOrder();
  }

 private:
  [[noreturn]] void Fail(int column, const std::string& reason) const { throw DatasetError(file_, line_, column, reason); }

  bool NextLine(std::string_view* line) {
    while (at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      *line = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++line_;
      const std::string_view content = Trimmed(*line);
      if (!content.empty() && content.front() != '#') return true;
    }
    return false;
  }

  void ReadHeader(const std::vector<Cell>& cells) {
    if (cells.size() > kMostColumns) Fail(1, "more than " + std::to_string(kMostColumns) + " columns");
    if (cells.front().text != "time") Fail(1, "the first column must be \"time\"");
    if (cells.size() < 4 || cells.size() % 3 != 1) Fail(1, "expected time,<sensor>.x,<sensor>.y,<sensor>.z and so on: three columns a sensor");
    std::set<std::string> known;
    for (std::size_t c = 1; c < cells.size(); ++c) {
      const std::string_view title = cells[c].text;
      const char axis = kAxes[(c - 1) % 3];
      if (title.size() < 3 || title[title.size() - 2] != '.' || title.back() != axis)
        Fail(cells[c].column, std::string("expected a column <sensor>.") + axis);
      const std::string name = Utf8FromUnknown(std::string(title.substr(0, title.size() - 2)));
      if (axis != 'x') {
        if (name != readings_.names.back()) Fail(cells[c].column, "expected a column of '" + readings_.names.back() + "'");
        continue;
      }
      if (!known.insert(name).second) Fail(cells[c].column, "'" + name + "' stands twice in the header");
      readings_.names.push_back(name);
    }
    columns_ = cells.size();
  }

  double Number(const Cell& cell) const {
    double value = 0;
    const char* first = cell.text.data();
    const char* last = first + cell.text.size();
    if (last - first > 1 && *first == '+' && first[1] != '-') ++first;  // from_chars takes no plus
    const auto [end, error] = std::from_chars(first, last, value);
    if (error != std::errc() || end != last || !std::isfinite(value)) {
      Fail(cell.column, std::string("not a number: ").append(cell.text.substr(0, 40)));
    }
    if (std::abs(value) > kLargestValue) Fail(cell.column, std::string("too large: ").append(cell.text.substr(0, 40)));
    return value;
  }

  void ReadRow(const std::vector<Cell>& cells) {
    if (cells.size() != columns_) Fail(1, "expected " + std::to_string(columns_) + " cells, found " + std::to_string(cells.size()));
    if (cells.front().text.empty() || IsNan(cells.front().text)) Fail(1, "a sample must have a time");
    times_.push_back(Number(cells.front()));
    if (std::abs(times_.back()) > kLongestTime_s) Fail(1, "the time must be in seconds, within 10^10 of 0");
    for (std::size_t c = 1; c < cells.size(); ++c) {
      const bool lost = cells[c].text.empty() || IsNan(cells[c].text);
      values_.push_back(lost ? std::numeric_limits<double>::quiet_NaN() : Number(cells[c]));
    }
  }

  Readings InOrder() {
    std::vector<std::size_t> order(times_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return times_[a] < times_[b]; });
    std::vector<std::size_t> kept;
    for (const std::size_t row : order) {
      if (!kept.empty() && times_[kept.back()] == times_[row]) kept.pop_back();
      kept.push_back(row);
    }
    const Eigen::Index rows = static_cast<Eigen::Index>(columns_) - 1;
    readings_.values.resize(rows, static_cast<Eigen::Index>(kept.size()));
    for (std::size_t i = 0; i < kept.size(); ++i) {
      readings_.times_s.push_back(times_[kept[i]]);
      readings_.values.col(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::VectorXd>(values_.data() + kept[i] * (columns_ - 1), rows);
    }
    return std::move(readings_);
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 0;
  std::size_t columns_ = 0;
  Readings readings_;
  std::vector<double> times_, values_;
};

}  // namespace

double Readings::rate_hz() const {
  if (times_s.size() < 2) return 0;
  std::vector<double> steps(times_s.size() - 1);
  for (std::size_t i = 0; i + 1 < times_s.size(); ++i) steps[i] = times_s[i + 1] - times_s[i];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle > 0 ? 1 / *middle : 0;
}

Readings ParseReadingsCsv(std::string_view text, const std::string& file) { return CsvReader(text, file).Read(); }

Readings ReadReadingsCsv(const std::filesystem::path& path) { return ParseReadingsCsv(ReadFileText(path), path.string()); }

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
