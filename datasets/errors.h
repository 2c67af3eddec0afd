#pragma once

#include <stdexcept>
#include <string>

namespace morphograph {

/// Bad data: says which file, where in it, and why.
///
/// `line` and `column` count from 1; 0 means "not tied to a place".
class DatasetError : public std::runtime_error {
 public:
  DatasetError(std::string file, int line, int column, const std::string& reason);
  DatasetError(std::string file, const std::string& reason);

  const std::string& file() const { return file_; }
  int line() const { return line_; }
  int column() const { return column_; }

 private:
  std::string file_;
  int line_;
  int column_;
};

}  // namespace morphograph
