#include "api/error_mapping.h"

#include <cstdio>
#include <new>

#include "api/training.h"
#include "datasets/errors.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {

Problem ProblemFrom(std::exception_ptr error) {
  Problem problem;
  try {
    std::rethrow_exception(error);
  } catch (const ProblemError& known) {
    problem = known.problem();
  } catch (const UnsatisfiableRequest& unmet) {
    problem.status = 422;
    problem.detail = "the request cannot be met";
    for (const UnmetField& field : unmet.unmet()) problem.errors.push_back({field.pointer, field.detail});
  } catch (const TrainingUsageError& unfit) {
    problem.status = 400;
    problem.detail = "the settings are malformed";
    problem.errors = {{unfit.pointer(), unfit.what()}};
  } catch (const DatasetError& bad_data) {
    problem.status = 400;
    problem.detail = bad_data.what();
  } catch (const std::bad_alloc&) {
    problem.status = 503;
    problem.detail = "not enough memory for this request now";
    problem.retry_after_s = 5;
  } catch (const std::exception& ours) {
    // The operator sees the reason, the client does not.
    std::fprintf(stderr, "morphograph: internal error: %s\n", ours.what());
    problem.detail = "the server failed; the request was not carried out";
  } catch (...) {
    std::fputs("morphograph: internal error of unknown type\n", stderr);
    problem.detail = "the server failed; the request was not carried out";
  }
  return problem;
}

HttpResponse ProblemResponse(const Problem& problem) {
  HttpResponse response;
  response.status = problem.status;
  response.Set("Content-Type", "application/problem+json");
  response.Set("Cache-Control", "no-store");
  if (!problem.allow.empty()) response.Set("Allow", problem.allow);
  if (problem.retry_after_s) response.Set("Retry-After", std::to_string(*problem.retry_after_s));
  response.body = ProblemJson(problem);
  return response;
}

}  // namespace morphograph
