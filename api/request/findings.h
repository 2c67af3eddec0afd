#pragma once

#include <string>
#include <vector>

#include "api/problem.h"

namespace morphograph {

/// Collects what is wrong with a request, so that its sender learns all of it at once.
///
/// A malformed field (400) outranks one that is well formed but cannot be met (422).
class Findings {
 public:
  /// @param subject  what is read, for the answer's first words.
  explicit Findings(std::string subject = "the clip request") : subject_(std::move(subject)) {}

  void Malformed(std::string pointer, std::string detail);
  void Unmeetable(std::string pointer, std::string detail);

  bool any() const { return !errors_.empty(); }
  /// Enough for one answer; readers of long lists stop then.
  bool full() const { return errors_.size() >= kMost; }

  /// @throws ProblemError
  void ThrowIfAny() const;

 private:
  static constexpr std::size_t kMost = 20;
  void Add(std::string pointer, std::string detail);

  std::string subject_;
  bool malformed_ = false;
  std::vector<FieldError> errors_;
};

/// A number as messages write it: shortest digits that read back the same.
std::string NumberText(double value);

}  // namespace morphograph
