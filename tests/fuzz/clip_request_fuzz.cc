// Clip requests from strangers: whatever the bytes, the parser answers with a request or a problem, and a request that it
// accepts survives its canonical form.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "api/clip_request.h"
#include "api/problem.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace morphograph;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const ClipRequest request = ParseClipRequest(text);
    const std::string canonical = CanonicalJson(request);
    if (CanonicalJson(ParseClipRequest(canonical)) != canonical) std::abort();
  } catch (const ProblemError& error) {
    const Problem& problem = error.problem();
    if (problem.status != 400 && problem.status != 422) std::abort();
    if (ProblemJson(problem).size() > 8192) std::abort();
  }
  return 0;
}
