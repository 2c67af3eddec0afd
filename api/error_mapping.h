#pragma once

#include <exception>

#include "api/http_message.h"
#include "api/problem.h"

namespace morphograph {

/// What a client is told of an exception. Only here are HTTP codes picked for errors of the libraries below:
/// bad data is 400, a request that cannot be met 422, lack of memory 503, anything else 500 without its text.
Problem ProblemFrom(std::exception_ptr error);

/// The `application/problem+json` answer.
HttpResponse ProblemResponse(const Problem& problem);

}  // namespace morphograph
