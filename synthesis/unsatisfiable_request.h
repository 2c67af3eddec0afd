#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace morphograph {

/// A request that is well formed but cannot be met: names the field (JSON pointer style, "/style").
class UnsatisfiableRequest : public std::runtime_error {
 public:
  UnsatisfiableRequest(std::string pointer, const std::string& detail)
      : std::runtime_error(detail), pointer_(std::move(pointer)) {}
  const std::string& pointer() const { return pointer_; }

 private:
  std::string pointer_;
};

}  // namespace morphograph
