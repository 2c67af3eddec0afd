#include "datasets/errors.h"

#include <utility>

namespace morphograph {
namespace {

std::string Format(const std::string& file, int line, int column, const std::string& reason) {
  std::string text = file;
  if (line > 0) text.append(":").append(std::to_string(line));
  if (line > 0 && column > 0) text.append(":").append(std::to_string(column));
  return text.append(": ").append(reason);
}

}  // namespace

DatasetError::DatasetError(std::string file, int line, int column, const std::string& reason)
    : std::runtime_error(Format(file, line, column, reason)), file_(std::move(file)), line_(line), column_(column) {}

DatasetError::DatasetError(std::string file, const std::string& reason) : DatasetError(std::move(file), 0, 0, reason) {}

}  // namespace morphograph
