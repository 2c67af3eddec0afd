#pragma once

#include <stdexcept>

#include "graph/motion_graph.h"
#include "synthesis/synthesis_types.h"

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

/// Draws a new clip from the graph (METHODS section 3): a legal walk over the graph, each step's vector from prior and
/// transition together, joined over the shared margins, planted feet locked.
///
/// Pure: same graph and request give the same clip, on any thread. Safe to call from many threads at once.
/// @throws std::invalid_argument on `request.FirstProblem()`; UnsatisfiableRequest for an unknown style.
SynthesisResult Synthesize(const MotionGraph& graph, const SynthesisRequest& request);

}  // namespace morphograph
