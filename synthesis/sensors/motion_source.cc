#include "synthesis/sensors/motion_source.h"

#include "datasets/parallel_for.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

constexpr int kWalksOfStyle = 20;
constexpr double kWalk_s = 12;

}  // namespace

MotionSource SourceOf(const MotionGraph& graph, int jobs) {
  if (graph.recordings()) {
    return {RecordedClips(*graph.recordings(), graph.layout(), graph.styles().front().mean_rotations), graph.recordings()->steps};
  }
  std::vector<SynthesisRequest> requests;
  for (const std::string& action : graph.action_names()) {
    std::vector<std::string> styles = graph.style_names(action);
    if (styles.empty()) styles.emplace_back();
    for (const std::string& style : styles) {
      for (int n = 0; n < kWalksOfStyle; ++n) {
        SynthesisRequest request;
        request.seed = static_cast<std::uint64_t>(n) + 1;
        if (!style.empty()) request.style = style;
        if (action != graph.action()) request.action = action;
        request.duration_s = kWalk_s;
        requests.push_back(std::move(request));
      }
    }
  }
  std::vector<SynthesisResult> made(requests.size());
  ParallelFor(jobs, static_cast<int>(requests.size()), [&](int i) { made[static_cast<std::size_t>(i)] = Synthesize(graph, requests[static_cast<std::size_t>(i)]); });
  MotionSource source;
  for (SynthesisResult& result : made) {
    const std::vector<StepReport>& steps = result.report.steps;
    for (std::size_t k = 1; k + 1 < steps.size(); ++k)
      source.steps.push_back({static_cast<int>(source.clips.size()), static_cast<double>(steps[k].from), static_cast<double>(steps[k + 1].from),
                              steps[k].primitive.starts_with("left")});
    source.clips.push_back(std::move(result.clip));
  }
  return source;
}

}  // namespace morphograph
