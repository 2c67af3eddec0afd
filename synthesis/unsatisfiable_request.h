#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace morphograph {

/// What a request asks for in vain: the field (JSON pointer style, "/style"), the reason and what could be had instead.
struct UnmetField {
  std::string pointer;
  std::string detail;
};

/// A request that is well formed but cannot be met.
class UnsatisfiableRequest : public std::runtime_error {
 public:
  UnsatisfiableRequest(std::string pointer, const std::string& detail)
      : UnsatisfiableRequest(std::vector<UnmetField>{UnmetField{std::move(pointer), detail}}) {}
  /// @param unmet  one or more.
  explicit UnsatisfiableRequest(std::vector<UnmetField> unmet) : std::runtime_error(unmet.at(0).detail), unmet_(std::move(unmet)) {}

  const std::string& pointer() const { return unmet_[0].pointer; }
  const std::vector<UnmetField>& unmet() const { return unmet_; }

 private:
  std::vector<UnmetField> unmet_;
};

}  // namespace morphograph
