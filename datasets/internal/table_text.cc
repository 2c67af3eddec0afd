#include "datasets/internal/table_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "datasets/errors.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

constexpr double kLongestTime_s = 1e10;  // times since 1970 are 1.8e9 s; milliseconds would be 1.8e12
constexpr double kLargestCell = 1e30;   // squares of it are still finite
constexpr std::size_t kQuotedLength = 40;

bool MeansLost(std::string_view text) {
  if (text.empty()) return true;
  if (text.size() != 3) return false;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return lower(text[0]) == 'n' && lower(text[1]) == 'a' && lower(text[2]) == 'n';
}

}  // namespace

std::string_view TrimmedText(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<TableCell> CellsOf(std::string_view line, char separator) {
  std::vector<TableCell> cells;
  for (std::size_t from = 0;;) {
    const std::size_t found = line.find(separator, from);
    const std::size_t to = std::min(found, line.size());
    cells.push_back({TrimmedText(line.substr(from, to - from)), static_cast<int>(from) + 1});
    if (found == std::string_view::npos) return cells;
    from = found + 1;
  }
}

TableText::TableText(std::string_view text, const std::string& file) : text_(text), file_(file) {
  if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
}

bool TableText::NextLine(std::string_view* line) {
  if (at_ >= text_.size()) return false;
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  *line = text_.substr(at_, end - at_);
  if (line->ends_with('\r')) line->remove_suffix(1);
  at_ = end + 1;
  ++line_;
  return true;
}

bool TableText::NextContent(std::string_view* line, std::string_view comment) {
  while (NextLine(line)) {
    const std::string_view content = TrimmedText(*line);
    if (!content.empty() && (comment.empty() || !content.starts_with(comment))) return true;
  }
  return false;
}

void TableText::Fail(int column, const std::string& reason) const { throw DatasetError(file_, line_, column, reason); }
void TableText::FailAsWhole(const std::string& reason) const { throw DatasetError(file_, reason); }

double TableText::Number(const TableCell& cell) const {
  double value = 0;
  const char* first = cell.text.data();
  const char* last = first + cell.text.size();
  if (last - first > 1 && *first == '+' && first[1] != '-') ++first;  // from_chars takes no plus
  const auto [end, error] = std::from_chars(first, last, value);
  if (error != std::errc() || end != last || !std::isfinite(value)) {
    Fail(cell.column, std::string("not a number: ").append(cell.text.substr(0, kQuotedLength)));
  }
  if (std::abs(value) > kLargestCell) Fail(cell.column, std::string("too large: ").append(cell.text.substr(0, kQuotedLength)));
  return value;
}

double TableText::NumberOrLost(const TableCell& cell) const {
  return MeansLost(cell.text) ? std::numeric_limits<double>::quiet_NaN() : Number(cell);
}

double TableText::Time(const TableCell& cell) const {
  if (MeansLost(cell.text)) Fail(cell.column, "a sample must have a time");
  const double time_s = Number(cell);
  if (std::abs(time_s) > kLongestTime_s) Fail(cell.column, "the time must be in seconds, within 10^10 of 0");
  return time_s;
}

std::string TableText::Name(const TableCell& cell) const {
  if (cell.text.empty()) Fail(cell.column, "a name is missing");
  if (cell.text.find_first_of(",\"") != std::string_view::npos) Fail(cell.column, "a name must hold no comma or quote");
  return Utf8FromUnknown(cell.text);
}

std::vector<std::size_t> RowsInOrder(const std::vector<double>& times_s) {
  std::vector<std::size_t> order(times_s.size()), kept;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return times_s[a] < times_s[b]; });
  for (const std::size_t row : order) {
    if (!kept.empty() && times_s[kept.back()] == times_s[row]) kept.pop_back();
    kept.push_back(row);
  }
  return kept;
}

Eigen::MatrixXd ColumnsOf(const std::vector<double>& table, std::size_t width, const std::vector<std::size_t>& rows, std::size_t first,
                          std::size_t count) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::VectorXd>(table.data() + rows[i] * width + first, static_cast<Eigen::Index>(count));
  }
  return columns;
}

Readings ReadingsInOrder(std::vector<std::string> names, const std::vector<double>& times_s, const std::vector<double>& values) {
  const std::vector<std::size_t> rows = RowsInOrder(times_s);
  Readings readings;
  readings.values = ColumnsOf(values, 3 * names.size(), rows, 0, 3 * names.size());
  readings.names = std::move(names);
  for (const std::size_t row : rows) readings.times_s.push_back(times_s[row]);
  return readings;
}

}  // namespace morphograph
