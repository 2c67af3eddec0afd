#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace morphograph {

/// What is wrong with one field of a request body.
struct FieldError {
  std::string pointer;  // JSON pointer (RFC 6901); empty for the whole body
  std::string detail;
};

/// An error as HTTP clients see it: problem details, RFC 9457.
struct Problem {
  int status = 500;
  std::string detail;
  std::vector<FieldError> errors;
  std::optional<int> retry_after_s;  // for 429 and 503
  std::string allow;                 // for 405: the methods that the route knows
};

/// Carries a problem out of a handler.
class ProblemError : public std::runtime_error {
 public:
  explicit ProblemError(Problem problem) : std::runtime_error(problem.detail), problem_(std::move(problem)) {}
  ProblemError(int status, std::string detail) : ProblemError(Problem{status, std::move(detail), {}, {}, {}}) {}

  const Problem& problem() const { return problem_; }

 private:
  Problem problem_;
};

/// Reason phrase of a status, "Not Found"; also a problem's title.
std::string_view StatusTitle(int status);

/// Body of an `application/problem+json` answer.
std::string ProblemJson(const Problem& problem);

/// The problem in one line, for the command line: detail, then each field with its reason.
std::string ProblemLine(const Problem& problem);

/// Appends a member name to a JSON pointer, escaped; long names are cut, so that an answer stays short.
std::string PointerTo(std::string_view parent, std::string_view member);

/// Text that came from a client, made fit for a message: cut to `limit` bytes at a character's end.
std::string Excerpt(std::string_view text, std::size_t limit = 64);

}  // namespace morphograph
