#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/readings.h"

namespace morphograph {

/// Without blanks, tabs and carriage returns at both ends.
std::string_view TrimmedText(std::string_view text);

struct TableCell {
  std::string_view text;  // trimmed
  int column = 0;         // of its first character in the line, from 1
};

/// Cells between separators; an empty line has one empty cell.
std::vector<TableCell> CellsOf(std::string_view line, char separator);

/// Walks through a table of text line by line, knowing where it is so that errors can say it. A byte order mark is passed over.
class TableText {
 public:
  /// @param file  name used in messages; must outlive this.
  TableText(std::string_view text, const std::string& file);

  /// False at the end of the text. The line comes without its end.
  bool NextLine(std::string_view* line);
  /// The same for lines that are not blank; those that begin with `comment` are passed over as well, unless it is empty.
  bool NextContent(std::string_view* line, std::string_view comment = "");
  int line() const { return line_; }

  /// @throws DatasetError at this line; column 0 means the whole line.
  [[noreturn]] void Fail(int column, const std::string& reason) const;
  [[noreturn]] void FailAsWhole(const std::string& reason) const;

  /// A finite number of at most 10^30. @throws DatasetError at the cell otherwise.
  double Number(const TableCell& cell) const;
  /// NaN for a cell that is empty or "nan", else Number().
  double NumberOrLost(const TableCell& cell) const;
  /// Number() of a time in seconds. @throws DatasetError also when it is lost, or cannot be seconds.
  double Time(const TableCell& cell) const;
  /// Name of a sensor or marker as UTF-8. @throws DatasetError when it is empty or holds a comma or a quote, which a CSV could not.
  std::string Name(const TableCell& cell) const;

 private:
  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 0;
};

/// Rows by rising time; of several with one time the last counts.
std::vector<std::size_t> RowsInOrder(const std::vector<double>& times_s);

/// Columns `first` and the `count` after it of chosen rows of a table stored row by row, (count x rows).
Eigen::MatrixXd ColumnsOf(const std::vector<double>& table, std::size_t width, const std::vector<std::size_t>& rows, std::size_t first, std::size_t count);

/// Readings from a table whose rows hold 3 values a name. @param values  row by row.
Readings ReadingsInOrder(std::vector<std::string> names, const std::vector<double>& times_s, const std::vector<double>& values);

}  // namespace morphograph
