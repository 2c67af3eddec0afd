#include "api/study/sample_sets.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "datasets/parallel_for.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {

std::vector<MotionClip> AtEvaluationRate(const std::vector<MotionClip>& clips, int jobs) {
  std::vector<MotionClip> sampled(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()), [&](int i) {
    const MotionClip& clip = clips[static_cast<size_t>(i)];
    const bool at_rate = std::abs(clip.frame_rate_hz() - kEvaluationRateHz) <= 1e-3 * kEvaluationRateHz;
    sampled[static_cast<size_t>(i)] = at_rate ? clip : Resample(clip, kEvaluationRateHz);
  });
  return sampled;
}

std::vector<MotionClip> Chosen(const std::vector<MotionClip>& clips, const std::vector<int>& which) {
  std::vector<MotionClip> chosen;
  for (const int i : which) chosen.push_back(clips.at(static_cast<size_t>(i)));
  return chosen;
}

StyledClips ByStyle(const std::vector<MotionClip>& clips) {
  StyledClips styled;
  for (const MotionClip& clip : clips) styled[clip.style].push_back(clip);
  return styled;
}

bool OfOneBody(const std::vector<MotionClip>& clips) {
  return std::all_of(clips.begin(), clips.end(), [&](const MotionClip& clip) { return SameBones(clip.skeleton(), clips.front().skeleton()); });
}

std::vector<MotionClip> OnBody(const std::vector<MotionClip>& clips, const std::shared_ptr<const Skeleton>& skeleton, int jobs) {
  std::vector<MotionClip> retargeted(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()),
              [&](int i) { retargeted[static_cast<size_t>(i)] = Retarget(clips[static_cast<size_t>(i)], skeleton); });
  return retargeted;
}

std::vector<MotionClip> Joined(const StyledClips& clips) {
  std::vector<MotionClip> joined;
  for (const auto& [style, of_style] : clips) joined.insert(joined.end(), of_style.begin(), of_style.end());
  return joined;
}

int PieceFrames(const std::vector<MotionClip>& clips) {
  for (const int frames : {90, 75, 60, 45, 30, 15}) {
    const auto hold = std::count_if(clips.begin(), clips.end(), [&](const MotionClip& clip) { return clip.frame_count() >= frames; });
    if (hold > 0 && 4 * hold >= 3 * static_cast<std::ptrdiff_t>(clips.size())) return frames;
  }
  throw std::invalid_argument("too few clips are as long as half a second");
}

std::vector<MotionClip> DrawClips(const MotionGraph& graph, const std::string& style, const DrawOptions& options) {
  std::vector<MotionClip> clips(static_cast<size_t>(options.clips));
  ParallelFor(options.jobs, options.clips, [&](int i) {
    SynthesisRequest request;
    request.seed = options.seed + static_cast<std::uint64_t>(i);
    request.style = style;
    request.duration_s = options.duration_s;
    request.frame_rate_hz = kEvaluationRateHz;
    clips[static_cast<size_t>(i)] = Synthesize(graph, request, options.variant).clip;
  });
  return clips;
}

StyledClips DrawStyles(const MotionGraph& graph, const DrawOptions& options, std::vector<std::string>* missing) {
  StyledClips drawn;
  for (const GraphStyle& style : graph.styles()) {
    try {
      drawn[style.name] = DrawClips(graph, style.name, options);
    } catch (const UnsatisfiableRequest&) {
      if (missing) missing->push_back(style.name);
    }
  }
  return drawn;
}

std::vector<MotionClip> InProportion(const StyledClips& synthesised, const StyledClips& captured) {
  const auto frames_of = [](const std::vector<MotionClip>& clips) {
    return std::accumulate(clips.begin(), clips.end(), 0.0, [](double sum, const MotionClip& clip) { return sum + clip.frame_count(); });
  };
  double most = 0;  // frames of a style
  for (const auto& [style, clips] : captured) most = std::max(most, frames_of(clips));
  std::vector<MotionClip> chosen;
  for (const auto& [style, clips] : synthesised) {
    const auto of_captured = captured.find(style);
    // A style that the data do not name apart is all of them.
    const double part = of_captured == captured.end() ? 1 : frames_of(of_captured->second) / most;
    const size_t count = std::max<size_t>(1, static_cast<size_t>(std::lround(part * static_cast<double>(clips.size()))));
    chosen.insert(chosen.end(), clips.begin(), clips.begin() + static_cast<std::ptrdiff_t>(std::min(count, clips.size())));
  }
  return chosen;
}

std::string StyleLabel(const std::string& style) { return style.empty() ? "all" : style; }

}  // namespace morphograph
