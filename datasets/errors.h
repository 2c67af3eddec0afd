#pragma once

#include <stdexcept>
#include <string>

namespace morphograph {

/// Bad data: says which file, where in it, and why.
///
/// `line` and `column` count from 1; 0 means "not tied to a place".
class DatasetError : public std::runtime_error {
 public:
  DatasetError(std::string file, int line, int column, const std::string& reason)
      : std::runtime_error(Format(file, line, column, reason)),
        file_(std::move(file)),
        line_(line),
        column_(column) {}
  DatasetError(std::string file, const std::string& reason)
      : DatasetError(std::move(file), 0, 0, reason) {}

  const std::string& file() const { return file_; }
  int line() const { return line_; }
  int column() const { return column_; }

 private:
  static std::string Format(const std::string& file, int line, int column,
                            const std::string& reason) {
    std::string text = file;
    if (line > 0) text += ":" + std::to_string(line);
    if (line > 0 && column > 0) text += ":" + std::to_string(column);
    return text + ": " + reason;
  }

  std::string file_;
  int line_;
  int column_;
};

}  // namespace morphograph
