#include "api/request/findings.h"

#include <nlohmann/json.hpp>

namespace morphograph {

void Findings::Malformed(std::string pointer, std::string detail) {
  malformed_ = true;
  Add(std::move(pointer), std::move(detail));
}

void Findings::Unmeetable(std::string pointer, std::string detail) { Add(std::move(pointer), std::move(detail)); }

void Findings::Add(std::string pointer, std::string detail) {
  if (!full()) errors_.push_back({std::move(pointer), std::move(detail)});
}

void Findings::ThrowIfAny() const {
  if (errors_.empty()) return;
  Problem problem;
  problem.status = malformed_ ? 400 : 422;
  problem.detail = subject_ + (malformed_ ? " is malformed" : " cannot be met");
  problem.errors = errors_;
  throw ProblemError(std::move(problem));
}

std::string NumberText(double value) { return nlohmann::json(value).dump(); }

}  // namespace morphograph
